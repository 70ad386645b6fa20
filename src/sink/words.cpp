#include "sink/words.h"

namespace vildar {

std::string_view sentence_for(Miss miss) {
  switch (miss) {
    case Miss::too_few_samples: return "There were too few frames or samples of it to fit a speed.";
    case Miss::too_short: return "It was in view for too short a time.";
    case Miss::no_time_spread: return "All of its samples carry the same time.";
    case Miss::below_noise: return "Its light did not stand out of the noise.";
    case Miss::saturated:
      return "Its lamps were too bright for the sensor, so that no usable light level was left.";
    case Miss::no_scale:
      return "Nothing in the site file (mounting height, lamp height or separation, lane) says how "
             "large a metre is in the picture.";
    case Miss::unobservable: return "The data fit many speeds equally well.";
    case Miss::outside_model:
      return "The data lie outside of what the method's model of road and light covers.";
    case Miss::not_converged: return "The fit did not settle on an answer.";
    case Miss::bad_fit:
      return "What was seen does not agree with the model of a vehicle on this road.";
    case Miss::too_uncertain:
      return "The speed could be told only within limits too wide to be of use.";
    case Miss::sensors_contradict:
      return "Two sensors disagree by more than their uncertainties allow.";
    case Miss::several_vehicles: return "Several vehicles lit the photodiode at the same time.";
    case Miss::ambiguous_identity:
      return "It could not be told apart from another vehicle, or is one seen a second time.";
    case Miss::direction_contradicts:
      return "The colour of its lamps and its motion say opposite directions of travel.";
    case Miss::not_on_road:
      return "It does not move like a lamp of a vehicle on the road: a reflection, perhaps.";
    case Miss::frames_missing:
      return "Frames are missing from the clip, and its time stamps go on as if none were.";
  }
  return "No reason is recorded.";
}

std::string_view words_for(Method method) {
  switch (method) {
    case Method::power_slope_camera: return "Power slope, camera";
    case Method::power_slope_photodiode: return "Power slope, photodiode";
    case Method::curved_angle_camera: return "Curved-road angle, camera";
    case Method::curved_angle_photodiode: return "Curved-road angle, photodiode";
    case Method::ml_photodiode: return "Maximum likelihood, photodiode";
    case Method::delay_photodiodes: return "Delay between photodiodes";
    case Method::geometry_camera: return "Geometry, camera";
    case Method::fused: return "Fused";
  }
  return "Unknown";
}

}  // namespace vildar
