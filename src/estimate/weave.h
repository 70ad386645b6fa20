#pragma once

#include "estimate/geometry_fit.h"

namespace vildar {

/// How far from its own middle line one who keeps to a lane goes, standard deviation, and over what
/// time he does so alike: exp(-(dt / time)^2 / 2). Of lane keeping the part that passes within
/// seconds, some decimetre. On a straight road what is quicker still may be his, too; on a bend it
/// is one who changes lanes.
inline constexpr double kWeave_m = 0.1;
inline double weaves_alike_s(const PathSetting& setting) { return setting.bend != 0.0 ? 1.5 : 1.0; }

/// Whether a weave is told from all else: not from high above a straight road, where elevations
/// tell the range and a camera that sways by a pixel or two looks like one who weaves. There it is
/// one of the things that may explain what a fit without it leaves.
bool weave_counts(const GeometryProblem& problem);

/// A vehicle's way to and fro within its lane looks like another speed where its bearing across the
/// road tells the range, and beside a bend like another radius: its curves, by HeadingSwings,
/// become unknowns of the fit, in place of the own vehicle's. On a straight road they are of the
/// range over `scale_m`, as if it was known, so that how far one weaves does not tell how far off
/// he is; on a bend, where one who leaves his lane is told by how far he goes, they are metres.
/// Nothing where weave_counts() says no.
void let_weave(GeometryProblem& problem, double scale_m);

}  // namespace vildar
