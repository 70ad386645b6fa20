#include "sink/annotator.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <opencv2/imgproc.hpp>

#include "core/text.h"
#include "sink/overlay.h"
#include "sink/picture.h"
#include "sink/video_encoder.h"

namespace vildar {
namespace {

constexpr int kReadableHeight_px = 720;
constexpr double kAssumedFrameRate_hz = 30.0;

int enlargement(int height_px) {
  return std::max(1, (kReadableHeight_px + height_px - 1) / height_px);
}
int even(int size_px) { return size_px + size_px % 2; }

VideoFormat format_for(int width_px, int height_px, double nominal_frame_rate_hz) {
  if (width_px <= 0 || height_px <= 0)
    throw std::invalid_argument("Annotator: picture size must be positive");
  const int factor = enlargement(height_px);
  // The rate only paces the encoder and shows the last frame; a clip that does not tell has one all
  // the same.
  const bool known = nominal_frame_rate_hz > 0.0 && std::isfinite(nominal_frame_rate_hz);
  return {even(width_px * factor), even(height_px * factor),
          known ? nominal_frame_rate_hz : kAssumedFrameRate_hz};
}

std::int64_t ticks_of(CameraTime time) { return std::llround(seconds_of(time) * kVideoTicksHz); }

}  // namespace

struct Annotator::Parts {
  Parts(const std::filesystem::path& path, int width, int height, double rate_hz,
        const AnnotatorOptions& options)
      : file(path),
        width_px(width),
        height_px(height),
        format(format_for(width, height, rate_hz)),
        encoder(file.part_path().string(), path.string(), format, options.encoders) {}

  AtomicFile file;
  int width_px;
  int height_px;
  VideoFormat format;
  VideoEncoder encoder;
  cv::Mat canvas;
  std::optional<std::int64_t> last_ticks;
};

Annotator::Annotator(const std::filesystem::path& path, int width_px, int height_px,
                     double nominal_frame_rate_hz, const AnnotatorOptions& options)
    : parts_(std::make_unique<Parts>(path, width_px, height_px, nominal_frame_rate_hz, options)) {}

Annotator::~Annotator() = default;

void Annotator::add(const Frame& frame, std::span<const AnnotationBox> boxes) {
  Parts& parts = *parts_;
  parts.canvas.create(parts.format.height_px, parts.format.width_px, CV_8UC3);
  parts.canvas.setTo(0);
  double scale = enlargement(parts.height_px);
  if (const cv::Mat picture = upright_picture(frame); !picture.empty()) {
    const double room =
        std::min(scale * parts.width_px / picture.cols, scale * parts.height_px / picture.rows);
    scale = room;
    const cv::Size shown(std::max(1, static_cast<int>(std::lround(picture.cols * scale))),
                         std::max(1, static_cast<int>(std::lround(picture.rows * scale))));
    cv::Mat place = parts.canvas(cv::Rect({0, 0}, shown));
    cv::resize(picture, place, shown, 0.0, 0.0, cv::INTER_LINEAR);
  }
  draw_vehicles(parts.canvas, scale, boxes);
  draw_caption(parts.canvas, fixed_text(seconds_of(frame.time), 3) + " s  frame " +
                                 std::to_string(frame.index) + (frame.damaged ? "  damaged" : ""));
  std::int64_t ticks = ticks_of(frame.time);
  if (parts.last_ticks) ticks = std::max(ticks, *parts.last_ticks + 1);
  parts.last_ticks = ticks;
  parts.encoder.add(parts.canvas, ticks);
}

AtomicFile Annotator::finish() {
  parts_->encoder.finish();
  parts_->file.finish();
  return std::move(parts_->file);
}

}  // namespace vildar
