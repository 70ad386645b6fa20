#pragma once

#include "config/lamp_classes.h"
#include "simulated_pass.h"

namespace vildar::simulated {

/// The site of mast_site() on a road of cars, lorries and motorcycles.
inline Site mixed_site(double camera_height_m) {
  Site site = mast_site(camera_height_m);
  site.lamps.classes = {{"car", 0.8, {0.68, 0.08}, Uncertain{1.25, 0.12}},
                        {"lorry", 0.15, {1.0, 0.08}, Uncertain{2.0, 0.1}},
                        {"motorcycle", 0.05, {0.85, 0.08}, std::nullopt}};
  pool_classes(site.lamps);
  return site;
}

}  // namespace vildar::simulated
