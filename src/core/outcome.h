#pragma once

#include <string_view>
#include <variant>

namespace vildar {

/// Why a speed is not given. The closed list behind `withheld:REASON`; see docs/outputs.md.
enum class Miss {
  too_few_samples,        ///< fewer samples or frames than the method needs
  too_short,              ///< in view for too short a time
  no_time_spread,         ///< all samples at one time
  below_noise,            ///< no received power above the noise
  saturated,              ///< clipped pixels or samples leave no usable intensity
  no_scale,               ///< nothing in the site file fixes the metric scale
  unobservable,           ///< the unknowns asked for cannot be told apart from these data
  outside_model,          ///< the data lie outside the domain of the model (e.g. nearer than d)
  not_converged,          ///< the solver did not reach a minimum
  bad_fit,                ///< the residuals contradict the model
  too_uncertain,          ///< the 95 % interval is wider than is useful
  sensors_contradict,     ///< two sensors disagree beyond their intervals
  several_vehicles,       ///< more than one vehicle feeds the same photodiode
  ambiguous_identity,     ///< the track may be of another vehicle in part, or of one seen twice
  direction_contradicts,  ///< lamp colour and motion disagree about the direction of travel
  not_on_road,            ///< does not move as a lamp at lamp height on the road does
  frames_missing,         ///< frames are missing whose time the stamps leave out
};

/// The snake_case name used in files.
std::string_view name_of(Miss miss);

/// A value, or the named reason why the night did not give one.
template <class T>
using Outcome = std::variant<T, Miss>;

}  // namespace vildar
