#include "core/outcome.h"

namespace vildar {

std::string_view name_of(Miss miss) {
  switch (miss) {
    case Miss::too_few_samples: return "too_few_samples";
    case Miss::too_short: return "too_short";
    case Miss::no_time_spread: return "no_time_spread";
    case Miss::below_noise: return "below_noise";
    case Miss::saturated: return "saturated";
    case Miss::no_scale: return "no_scale";
    case Miss::unobservable: return "unobservable";
    case Miss::outside_model: return "outside_model";
    case Miss::not_converged: return "not_converged";
    case Miss::bad_fit: return "bad_fit";
    case Miss::too_uncertain: return "too_uncertain";
    case Miss::sensors_contradict: return "sensors_contradict";
    case Miss::several_vehicles: return "several_vehicles";
    case Miss::ambiguous_identity: return "ambiguous_identity";
    case Miss::direction_contradicts: return "direction_contradicts";
    case Miss::not_on_road: return "not_on_road";
    case Miss::frames_missing: return "frames_missing";
  }
  return "unknown";
}

}  // namespace vildar
