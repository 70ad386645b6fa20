#include "capture/photodiode_sound.h"

#include <sndfile.h>

#include <array>
#include <cmath>
#include <fstream>
#include <memory>
#include <optional>
#include <string_view>

#include "core/error.h"

namespace vildar {
namespace {

struct Close {
  void operator()(SNDFILE* file) const { ::sf_close(file); }
};
using SoundFile = std::unique_ptr<SNDFILE, Close>;

/// Bits of one whole-numbered sample; nothing for a floating-point file.
std::optional<int> bits_of(int format) {
  switch (format & SF_FORMAT_SUBMASK) {
    case SF_FORMAT_PCM_S8:
    case SF_FORMAT_PCM_U8: return 8;
    case SF_FORMAT_PCM_16: return 16;
    case SF_FORMAT_PCM_24: return 24;
    case SF_FORMAT_PCM_32: return 32;
    default: return std::nullopt;
  }
}

SoundFile opened(const std::filesystem::path& path, std::size_t photodiodes, SF_INFO& info) {
  SoundFile file(::sf_open(path.c_str(), SFM_READ, &info));
  if (!file)
    throw InputError(path.string() + ": cannot be read as WAV or FLAC: " + ::sf_strerror(nullptr) +
                     "; record or convert the trace again");
  constexpr int kLowest_hz = 100, kHighest_hz = 100'000;
  if (info.samplerate < kLowest_hz || info.samplerate > kHighest_hz)
    throw InputError(path.string() + ": has " + std::to_string(info.samplerate) +
                     " samples a second, must be 100 to 100000; record or resample it so");
  if (static_cast<std::size_t>(info.channels) > photodiodes)
    throw InputError(path.string() + ": has " + std::to_string(info.channels) +
                     " channels, but the site file has " + std::to_string(photodiodes) +
                     " photodiodes; describe each under photodiodes: in the channels' order");
  return file;
}

/// Frames that the header promises, where libsndfile noted that the file is shorter.
bool cut_short(SNDFILE* file) {
  std::array<char, 16384> log{};
  ::sf_command(file, SFC_GET_LOG_INFO, log.data(), static_cast<int>(log.size()) - 1);
  const std::string_view text = log.data();
  return text.find("(should be") != std::string_view::npos;
}

}  // namespace

bool is_sound_file(const std::filesystem::path& path) {
  std::array<char, 4> start{};
  std::ifstream(path, std::ios::binary).read(start.data(), start.size());
  const std::string_view magic(start.data(), start.size());
  return magic == "RIFF" || magic == "RIFX" || magic == "RF64" || magic == "fLaC";
}

PhotodiodeRecording read_photodiode_sound(const std::filesystem::path& path,
                                          std::span<const PhotodiodeSite> photodiodes) {
  SF_INFO info{};
  const SoundFile file = opened(path, photodiodes.size(), info);
  const auto channels = static_cast<std::size_t>(info.channels);
  PhotodiodeRecording recording;
  recording.quantity = PowerQuantity::counts;
  recording.shares = true;
  const std::optional<int> bits = bits_of(info.format);
  std::vector<float> scale;
  for (std::size_t channel = 0; channel < channels; ++channel) {
    const PhotodiodeSite& photodiode = photodiodes[channel];
    recording.ids.push_back(photodiode.id);
    scale.push_back(bits && photodiode.volts_per_count ? std::ldexp(1.0F, *bits - 1) : 1.0F);
  }
  recording.values.resize(channels);

  constexpr std::size_t kFramesAtOnce = 65536;
  std::vector<float> buffer(kFramesAtOnce * channels);
  for (;;) {
    const sf_count_t read =
        ::sf_readf_float(file.get(), buffer.data(), static_cast<sf_count_t>(kFramesAtOnce));
    if (read <= 0) break;
    for (std::size_t channel = 0; channel < channels; ++channel)
      for (std::size_t frame = 0; frame < static_cast<std::size_t>(read); ++frame)
        recording.values[channel].push_back(scale[channel] * buffer[frame * channels + channel]);
    recording.rows_read += read;
  }
  if (recording.rows_read == 0)
    throw InputError(path.string() + ": holds no sample; record the trace again");
  if (::sf_error(file.get()) != SF_ERR_NO_ERROR || recording.rows_read < info.frames ||
      cut_short(file.get())) {
    recording.damaged = true;
    recording.warnings.push_back(path.string() + ": ends after " +
                                 std::to_string(recording.rows_read) +
                                 " samples, before its header says; what there is was used");
  }
  recording.time_s.reserve(static_cast<std::size_t>(recording.rows_read));
  for (std::int64_t frame = 0; frame < recording.rows_read; ++frame)
    recording.time_s.push_back(static_cast<double>(frame) / info.samplerate);
  return recording;
}

}  // namespace vildar
