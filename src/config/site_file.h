#pragma once

#include <filesystem>
#include <string>

#include "config/yaml_reader.h"
#include "types/site.h"

namespace vildar {

/// Reads a site file (version 1). Angles become radians, paths absolute or relative to the working
/// folder, and the ego trace is read. Throws ConfigError with every problem of the file.
///
/// Required: `version`; a camera or a photodiode; of the camera its image size, focal lengths,
/// principal point and position (an angle left out is 0 with a std of 5 degrees, 2 for the roll);
/// of a photodiode its position (and `id` where there are several; a lone one is `pd0` unless
/// named); of a lane `id`, `lateral_m` and `direction`. A missing optional quantity stays unknown
/// (nullopt) or at the default of types/site.h.
Site load_site(const std::filesystem::path& file);

/// The same from a map that stands inside another file (a scenario), without `version`. Problems
/// go to the reader of that map.
Site read_site(const YamlMap& map);

/// The settings in force as a site file: loading it gives an equal Site, whatever folder it is put
/// in.
std::string effective_site_yaml(const Site& site);

/// Throws ConfigError where the site has no camera or its image size is not that of the clip.
/// `width_px` and `height_px` are those of the upright image.
void check_site_fits_clip(const Site& site, int width_px, int height_px);

}  // namespace vildar
