#pragma once

#include <span>

namespace vildar {

/// out[i] = ln(in[i]) for many values at once, to a few units in the last place, with the widest
/// vectors that the processor has. `in` and `out` may be the same; sizes must agree. Values must be
/// positive and finite; others give no defined result and must be screened before.
void natural_logs(std::span<const double> in, std::span<double> out);

/// out[i] = exp(in[i]); likewise, for finite values.
void exponentials(std::span<const double> in, std::span<double> out);

/// out[i] = arctan(in[i]) in radians; likewise, and of infinite values.
void arctangents(std::span<const double> in, std::span<double> out);

/// Of angles within some hundred radians; likewise.
void sines(std::span<const double> in_rad, std::span<double> out);
void cosines(std::span<const double> in_rad, std::span<double> out);

}  // namespace vildar
