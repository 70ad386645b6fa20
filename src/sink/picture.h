#pragma once

#include <opencv2/core.hpp>

#include "types/frame.h"

namespace vildar {

/// The frame as people see it: upright, 8-bit BGR, code range and bit depth honoured. Colours
/// follow BT.709 from 720 rows on and BT.601 below, which is what a clip means that does not say.
/// An empty picture for a frame without pixels.
cv::Mat upright_picture(const Frame& frame);

}  // namespace vildar
