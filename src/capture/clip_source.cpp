#include "capture/clip_source.h"

#include <cmath>
#include <stdexcept>
#include <string_view>

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libavutil/display.h>
#include <libavutil/pixdesc.h>
}

#include "capture/clip_decoder.h"
#include "capture/frame_clock.h"
#include "capture/picture_view.h"
#include "capture/row_maxima.h"
#include "core/error.h"
#include "core/text.h"

namespace vildar {
namespace {

constexpr double kRateToTellOf = 0.01;  // a rate wrong by 1 % is a speed wrong by 1 %

std::string joined(const std::vector<std::string>& parts) {
  std::string text;
  for (const std::string& part : parts) text += (text.empty() ? "" : "; ") + part;
  return text;
}

std::chrono::nanoseconds period_of(double rate_hz) {
  return std::chrono::nanoseconds(std::llround(1e9 / rate_hz));
}

}  // namespace

std::vector<std::string> ClipOptions::problems() const {
  std::vector<std::string> found;
  if (frame_rate_hz && !(*frame_rate_hz > 0.0 && *frame_rate_hz <= 1e6))
    found.push_back("frame_rate_hz = " + std::to_string(*frame_rate_hz) + ", must be in (0, 1e6]");
  if (decoder_threads < 1 || decoder_threads > 64)
    found.push_back("decoder_threads = " + std::to_string(decoder_threads) +
                    ", must be in [1, 64]");
  return found;
}

bool ClipCounts::damaged() const {
  return truncated || frames_damaged > 0 || packets_damaged > 0 || frames_of_other_size > 0 ||
         time_stamps_repaired > 0;
}

struct ClipSource::Impl {
  Impl(const std::filesystem::path& path, const ClipOptions& chosen);

  std::optional<Frame> next();

  ClipOptions options;
  ClipDecoder decoder;
  FrameClock clock;
  LumaMaker luma_maker;
  std::optional<DecodedPicture> ahead;  ///< decoded already, given next
  int stored_width_px = 0, stored_height_px = 0;
  bool finished = false, interlaced = false;
  bool after_damage = false;  ///< a damaged picture came and no key frame since
  std::int64_t first_damaged = 0, first_of_other_size = 0;
  ClipInfo info;
  ClipCounts counts;

 private:
  void describe(const AVFrame& first);
  void find_rotation(const AVFrame& first);
  std::optional<DecodedPicture> take();
  CameraTime time_of(const DecodedPicture& decoded);
  SharedPicture with_luma(SharedPicture picture);
  void finish();
  void warn(const std::string& text) {
    counts.warnings.push_back(info.path.string() + ": " + text);
  }
  FrameClock make_clock() const {
    const double rate_hz = decoder.declared_rate_hz();
    return FrameClock(period_of(rate_hz > 0.0 ? rate_hz : kRateWhereNoneIsDeclaredHz));
  }
  static constexpr double kRateWhereNoneIsDeclaredHz = 30.0;
};

ClipSource::Impl::Impl(const std::filesystem::path& path, const ClipOptions& chosen)
    : options(chosen), decoder(path, chosen), clock(make_clock()) {
  info.path = path;
  ahead = decoder.next();
  if (!ahead) {
    const std::vector<std::string> lines = decoder.log().lines();
    throw InputError(path.string() + ": not one picture can be decoded, in " +
                     std::to_string(decoder.packets_read()) + " packets of video" +
                     (lines.empty() ? "" : " (" + joined(lines) + ")") +
                     "; copy it from the recorder again");
  }
  if (with_luma(ahead->picture) == nullptr)
    throw InputError(path.string() + ": pixel format " +
                     av_get_pix_fmt_name(static_cast<AVPixelFormat>(ahead->picture->format)) +
                     " cannot be turned into luma; convert the clip to yuv420p");
  describe(*ahead->picture);
}

void ClipSource::Impl::describe(const AVFrame& first) {
  const AVFormatContext& container = decoder.container();
  const AVStream& stream = decoder.stream();
  stored_width_px = first.width;
  stored_height_px = first.height;
  info.container = container.iformat->name;
  info.codec = avcodec_get_name(stream.codecpar->codec_id);
  const AVCodecDescriptor* codec = avcodec_descriptor_get(stream.codecpar->codec_id);
  info.lossless = codec != nullptr && (codec->props & AV_CODEC_PROP_LOSSLESS) != 0 &&
                  (codec->props & AV_CODEC_PROP_LOSSY) == 0;
  info.pixel_format = av_get_pix_fmt_name(static_cast<AVPixelFormat>(first.format));
  Frame probe;
  const SharedPicture readable = with_luma(ahead->picture);
  set_views(readable, probe);
  info.bit_depth = probe.luma.bit_depth;
  const PictureRange range = range_of(*readable);
  info.colour_range =
      std::string(range.full ? "full" : "limited") + (range.assumed ? " (assumed)" : "");
  info.nominal_frame_rate_hz = decoder.declared_rate_hz();
  info.duration_s = decoder.declared_duration_s();
  if (stream.nb_frames > 0) info.frames_declared = stream.nb_frames;
  info.frame_rate_overridden = options.frame_rate_hz.has_value();
  find_rotation(first);
  const bool sideways = info.rotation_deg % 180 != 0;
  info.width_px = sideways ? first.height : first.width;
  info.height_px = sideways ? first.width : first.height;
  const AVRational aspect =
      stream.sample_aspect_ratio.num > 0 ? stream.sample_aspect_ratio : first.sample_aspect_ratio;
  if (aspect.num > 0 && aspect.den > 0)
    info.pixel_aspect = sideways ? 1.0 / av_q2d(aspect) : av_q2d(aspect);
  if (info.frame_rate_overridden) return;
  const bool bare_stream = (container.iformat->flags & AVFMT_NOTIMESTAMPS) != 0 ||
                           std::string_view(container.iformat->long_name).starts_with("raw ");
  if (bare_stream)
    warn("this kind of file holds no time stamps; taken at " +
         fixed_text(info.nominal_frame_rate_hz, 3) + " frames/s; give the true frame rate");
  else if (info.nominal_frame_rate_hz == 0.0)
    warn("declares no frame rate; missing stamps would be filled at " +
         fixed_text(kRateWhereNoneIsDeclaredHz, 0) + " frames/s; give the true frame rate");
}

void ClipSource::Impl::find_rotation(const AVFrame& first) {
  const AVFrameSideData* in_picture = av_frame_get_side_data(&first, AV_FRAME_DATA_DISPLAYMATRIX);
  std::size_t size = 0;
  const std::uint8_t* bytes =
      av_stream_get_side_data(&decoder.stream(), AV_PKT_DATA_DISPLAYMATRIX, &size);
  if (bytes == nullptr && in_picture != nullptr) {
    bytes = in_picture->data;
    size = in_picture->size;
  }
  if (bytes == nullptr || size < 9 * sizeof(std::int32_t)) return;
  const auto* matrix = reinterpret_cast<const std::int32_t*>(bytes);
  const double clockwise_deg = -av_display_rotation_get(matrix);
  if (!std::isfinite(clockwise_deg)) return;
  const int quarter_turns = static_cast<int>(std::lround(clockwise_deg / 90.0));
  info.rotation_deg = (quarter_turns % 4 + 4) % 4 * 90;
  if (std::abs(clockwise_deg - 90.0 * quarter_turns) > 1.0)
    warn("asks to be shown turned by " + fixed_text(clockwise_deg, 1) + " degrees; taken as " +
         std::to_string(info.rotation_deg) + "; put the rest into roll_deg of the camera");
  const double determinant =
      static_cast<double>(matrix[0]) * matrix[4] - static_cast<double>(matrix[1]) * matrix[3];
  if (determinant < 0.0)
    warn(
        "asks to be shown mirrored, which is not done; left and right are those of the stored "
        "picture");
}

SharedPicture ClipSource::Impl::with_luma(SharedPicture picture) {
  return has_luma_plane(*picture) ? picture : luma_maker.converted(*picture);
}

std::optional<DecodedPicture> ClipSource::Impl::take() {
  if (!ahead) return decoder.next();
  std::optional<DecodedPicture> taken = std::move(ahead);
  ahead.reset();
  return taken;
}

CameraTime ClipSource::Impl::time_of(const DecodedPicture& decoded) {
  if (options.frame_rate_hz)
    return time_from_seconds<CameraTime>(static_cast<double>(counts.frames_read) /
                                         *options.frame_rate_hz);
  FrameClock::Stamp next_stamp;
  if (clock.doubts(decoded.stamp)) {
    if (!ahead) ahead = decoder.next();
    if (ahead) next_stamp = ahead->stamp;
  }
  return CameraTime(clock.place(decoded.stamp, next_stamp));
}

std::optional<Frame> ClipSource::Impl::next() {
  while (!finished) {
    std::optional<DecodedPicture> decoded = take();
    if (!decoded) {
      finish();
      break;
    }
    Frame frame;
    frame.time = time_of(*decoded);
    frame.index = counts.frames_read++;
    frame.rotation_deg = info.rotation_deg;
    if (decoded->damaged)
      after_damage = true;
    else if (decoded->picture->key_frame != 0)
      after_damage = false;
    frame.damaged = after_damage;
    const bool said = decoded->picture->interlaced_frame != 0;
    const bool fields = said || options.one_field;
    interlaced = interlaced || fields;
    if (decoded->damaged) {
      if (counts.frames_damaged++ == 0) first_damaged = frame.index;
    } else if (frame.damaged) {
      ++counts.frames_after_damage;
    }
    const SharedPicture readable = with_luma(decoded->picture);
    const bool fits =
        decoded->picture->width == stored_width_px && decoded->picture->height == stored_height_px;
    if (!fits || readable == nullptr) {
      if (counts.frames_of_other_size++ == 0) first_of_other_size = frame.index;
      continue;
    }
    const bool top = !said || decoded->picture->top_field_first != 0;
    set_views(fields ? one_field_of(*readable, top) : readable, frame);
    if (!frame.damaged && !fields) frame.luma.row_maxima = row_maxima_of(*readable);
    return frame;
  }
  return std::nullopt;
}

void ClipSource::Impl::finish() {
  finished = true;
  counts.packets_damaged = decoder.damaged_packets();
  counts.truncated = decoder.truncated();
  const auto number = [](std::int64_t count) { return std::to_string(count); };
  if (!options.frame_rate_hz) {
    counts.time_stamps_repaired = clock.repaired();
    counts.frames_dropped = clock.dropped();
    const std::optional<double> observed_hz = clock.observed_rate_hz();
    const double nominal_hz = info.nominal_frame_rate_hz;
    if (observed_hz && nominal_hz > 0.0 &&
        std::abs(*observed_hz / nominal_hz - 1.0) > kRateToTellOf)
      warn("declares " + fixed_text(nominal_hz, 3) + " frames/s but its time stamps say " +
           fixed_text(*observed_hz, 3) +
           "; the stamps are used; give the frame rate if they are wrong");
    if (counts.time_stamps_repaired > 0)
      warn(number(counts.time_stamps_repaired) +
           " time stamps are missing, repeated or out of order, the first at frame " +
           number(clock.first_repaired()) +
           "; replaced by their neighbours'; give the frame rate if it is steady");
  }
  const std::vector<std::string> lines = decoder.log().lines();
  if (counts.frames_damaged > 0 || counts.packets_damaged > 0)
    warn(number(counts.frames_damaged) + " of " + number(counts.frames_read) +
         " frames are damaged" +
         (counts.frames_damaged > 0 ? ", the first is frame " + number(first_damaged) : "") +
         (counts.frames_after_damage > 0 ? ", and " + number(counts.frames_after_damage) +
                                               " up to the next key frame rest on them"
                                         : "") +
         " (" + number(counts.packets_damaged) + " bad packets" +
         (lines.empty() ? "" : ": " + joined(lines)) + "); copy the clip from the recorder again");
  if (counts.frames_of_other_size > 0)
    warn(number(counts.frames_of_other_size) + " frames are not " + number(stored_width_px) +
         " x " + number(stored_height_px) + " pixels, the first is frame " +
         number(first_of_other_size) + "; left out; cut the clip there and run the parts apart");
  if (counts.truncated)
    warn("ends early: " + number(counts.frames_read) + " frames read" +
         (info.frames_declared ? " of " + number(*info.frames_declared) + " declared" : "") +
         "; copy the clip from the recorder again");
  if (interlaced)
    warn(std::string("is interlaced") + (options.one_field ? " without a word of it" : "") +
         ": odd and even rows were taken at different times, and " +
         (options.one_field ? "the odd ones" : "those of the later half") +
         " are not read; record progressive video");
}

ClipSource::ClipSource(std::filesystem::path path, ClipOptions options) {
  if (const std::vector<std::string> problems = options.problems(); !problems.empty())
    throw std::invalid_argument("ClipOptions: " + joined(problems));
  impl_ = std::make_unique<Impl>(path, options);
}
ClipSource::~ClipSource() = default;
ClipSource::ClipSource(ClipSource&&) noexcept = default;
ClipSource& ClipSource::operator=(ClipSource&&) noexcept = default;

std::optional<Frame> ClipSource::next() { return impl_->next(); }
const ClipInfo& ClipSource::info() const { return impl_->info; }
const ClipCounts& ClipSource::counts() const { return impl_->counts; }

}  // namespace vildar
