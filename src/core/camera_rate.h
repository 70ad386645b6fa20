#pragma once

namespace vildar {

/// Whether cameras take frames at a rate that near to this one, or at that of television beside it
/// (1000/1001 of it). `off`: share of the rate.
bool is_camera_rate(double rate_hz, double off);

}  // namespace vildar
