#pragma once

#include <cstdint>

struct AVCodecContext;
struct AVFrame;

namespace vildar {

/// Has a decoder of one thread, not opened yet, note the greatest code of each row of its pictures
/// while the row is still in the processor's cache: reading it again later costs more than this.
/// Works where the decoder tells of rows as they are finished, and for 8 bits.
void note_row_maxima(AVCodecContext& codec);

/// Of each row of a picture, or of more than the part of a row that is shown; null where not all
/// are known. Lives as long as the picture. Means nothing where the decoder mended damage.
const std::uint8_t* row_maxima_of(const AVFrame& picture);

}  // namespace vildar
