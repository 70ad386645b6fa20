#pragma once

#include <vector>

#include "types/power.h"

namespace vildar {

/// Keeps the blocks between two edges of the light that hold most of it above `ambient_w`. An edge,
/// where a mask or the rim of the photodiode's view takes a lamp away or lets it in, is a change
/// within some three blocks that the light before and after it does not lead to; the blocks that
/// it may reach go too. Blocks: in order of time, of one length; across a gap no edge is
/// told. `finer`: the same light in shorter blocks, in which edges are told too.
void keep_between_edges(std::vector<PowerBlock>& blocks, double ambient_w,
                        const std::vector<PowerBlock>& finer = {});

}  // namespace vildar
