#pragma once

#include <array>

#include "config/yaml_reader.h"

namespace vildar {

/// The words of the site file and what they mean, for reading and for writing.
inline constexpr std::array<Choice<DistortionModel>, 3> kDistortionWords{
    {{"none", DistortionModel::none},
     {"brown", DistortionModel::brown},
     {"fisheye", DistortionModel::fisheye}}};
inline constexpr std::array<Choice<ResponseKind>, 5> kResponseWords{
    {{"linear", ResponseKind::linear},
     {"gamma", ResponseKind::gamma},
     {"srgb", ResponseKind::srgb},
     {"bt709", ResponseKind::bt709},
     {"table", ResponseKind::table}}};
inline constexpr std::array<Choice<RoadKind>, 2> kRoadWords{
    {{"straight", RoadKind::straight}, {"curved", RoadKind::curved}}};
inline constexpr std::array<Choice<Turn>, 2> kTurnWords{
    {{"left", Turn::left}, {"right", Turn::right}}};
inline constexpr std::array<Choice<Direction>, 2> kDirectionWords{
    {{"oncoming", Direction::oncoming}, {"receding", Direction::receding}}};

inline constexpr std::size_t kResponseTableSize = 256;

/// Coefficients that a distortion model takes: brown k1 k2 p1 p2 k3, fisheye k1 to k4.
constexpr std::size_t coefficient_count(DistortionModel model) {
  switch (model) {
    case DistortionModel::none: return 0;
    case DistortionModel::brown: return 5;
    case DistortionModel::fisheye: return 4;
  }
  return 0;
}

}  // namespace vildar
