#pragma once

#include <cstdint>
#include <span>

#include "types/blob.h"
#include "types/frame.h"

namespace vildar {

/// Tells clips whose pictures are woven of two fields without a word of it: of a lamp that moves
/// sideways every other row stands beside the rows between. Pictures that are shown turned are not
/// looked at.
class Combing {
 public:
  /// Looks at the lamps of every fourth frame that are eight rows high or more, and 32 codes
  /// bright.
  void add(const Frame& frame, std::span<const Blob> blobs);

  std::int64_t judged() const { return judged_; }  ///< lamps whose rows could be told apart
  std::int64_t combed() const { return combed_; }
  /// Whether so many of them are that it is no chance.
  bool told() const;

 private:
  std::int64_t judged_ = 0, combed_ = 0;
};

}  // namespace vildar
