#pragma once

#include <span>
#include <string>
#include <vector>

#include <opencv2/core.hpp>

#include "sink/annotator.h"

namespace vildar {

/// Draws vehicles onto an upright picture that was enlarged `scale` times. Labels step aside for
/// one another and, where there is room, for every vehicle's lamps (a line leads back to the
/// vehicle); nothing is drawn outside the picture.
void draw_vehicles(cv::Mat& canvas, double scale, std::span<const AnnotationBox> boxes);

/// A line of text on a dark plate in the top left corner.
void draw_caption(cv::Mat& canvas, const std::string& text);

/// Outline of the vehicle behind its lamps, in picture pixels: lamps sit near the lower third of a
/// vehicle about 1.4 times as wide as its lamps are apart. A single lamp gives a square about it.
cv::Rect2d vehicle_outline(const AnnotationBox& box);

}  // namespace vildar
