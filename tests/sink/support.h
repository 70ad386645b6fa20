#pragma once

#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "core/error.h"
#include "types/result.h"

namespace vildar::test {

/// A new empty folder that goes away with the object.
class Folder {
 public:
  Folder() {
    std::string name = (std::filesystem::temp_directory_path() / "vildar_sink_XXXXXX").string();
    if (::mkdtemp(name.data()) == nullptr) throw std::runtime_error("no temporary folder");
    path_ = name;
  }
  ~Folder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  const std::filesystem::path& path() const { return path_; }
  std::filesystem::path operator/(const char* name) const { return path_ / name; }

 private:
  std::filesystem::path path_;
};

inline std::string text_of(const std::filesystem::path& path) {
  std::ifstream stream(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

inline std::vector<std::string> lines_of(const std::filesystem::path& path) {
  std::ifstream stream(path);
  std::vector<std::string> lines;
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

inline VehicleResult measured_vehicle() {
  VehicleResult vehicle;
  vehicle.track_id = 3;
  vehicle.lane = "near, left";
  vehicle.t_first_s = 1.25;
  vehicle.t_last_s = 4.5;
  vehicle.speed = {2.125, 14.5, 0.2, 14.108, 14.892, 98};
  vehicle.range_ref_m = 31.5;
  vehicle.lateral_m = -4.0;
  vehicle.closing_speed_mps = 14.5;
  vehicle.used_camera = vehicle.used_photodiode = true;
  vehicle.method = Method::fused;
  vehicle.n_frames = 98;
  vehicle.n_pd_samples = 3250;
  vehicle.methods = {{Method::power_slope_photodiode, vehicle.speed, 3250, "bearings"},
                     {Method::curved_angle_camera, Miss::outside_model, 98, ""}};
  return vehicle;
}

inline VehicleResult withheld_vehicle() {
  VehicleResult vehicle;
  vehicle.track_id = 4;
  vehicle.direction = Direction::receding;
  vehicle.t_first_s = 5.0;
  vehicle.t_last_s = 5.2;
  vehicle.withheld = Miss::too_short;
  vehicle.range_ref_m = 80.0;  // known, but holds at no time that the row could give
  vehicle.used_camera = true;
  vehicle.n_frames = 6;
  return vehicle;
}

}  // namespace vildar::test
