#include "capture/photodiode_sound.h"

#include <sndfile.h>

#include <cmath>
#include <fstream>

#include "core/error.h"
#include "support/temporary_folder.h"

namespace vildar {
namespace {

namespace fs = std::filesystem;

std::vector<PhotodiodeSite> photodiodes(std::size_t count) {
  std::vector<PhotodiodeSite> diodes(count);
  for (std::size_t i = 0; i < count; ++i) diodes[i].id = "pd" + std::to_string(i);
  return diodes;
}

/// A file of interleaved 16-bit codes, or of floats where `format` says so.
fs::path written(const fs::path& path, int format, int rate_hz, int channels,
                 const std::vector<double>& fractions) {
  SF_INFO info{};
  info.format = format;
  info.samplerate = rate_hz;
  info.channels = channels;
  SNDFILE* file = ::sf_open(path.c_str(), SFM_WRITE, &info);
  EXPECT_NE(file, nullptr) << ::sf_strerror(nullptr);
  if ((format & SF_FORMAT_SUBMASK) == SF_FORMAT_FLOAT) {
    ::sf_write_double(file, fractions.data(), static_cast<sf_count_t>(fractions.size()));
  } else {
    std::vector<short> codes;
    for (const double fraction : fractions)
      codes.push_back(static_cast<short>(std::lround(32768.0 * fraction)));
    ::sf_write_short(file, codes.data(), static_cast<sf_count_t>(codes.size()));
  }
  ::sf_close(file);
  return path;
}

const std::vector<double> kFractions{0.0, 0.5, -0.25, 0.125, 0.75, -1.0};

TEST(PhotodiodeSound, ChannelsAreThePhotodiodesOfTheSiteInOrder) {
  const TemporaryFolder folder;
  for (const int container : {SF_FORMAT_WAV, SF_FORMAT_FLAC, SF_FORMAT_RF64}) {
    const fs::path path =
        written(folder.path() / "trace", container | SF_FORMAT_PCM_16, 8000, 2, kFractions);
    EXPECT_TRUE(is_sound_file(path));
    const PhotodiodeRecording recording = read_photodiode_sound(path, photodiodes(3));
    EXPECT_EQ(recording.quantity, PowerQuantity::counts);
    EXPECT_EQ(recording.ids, (std::vector<std::string>{"pd0", "pd1"}));
    EXPECT_EQ(recording.time_s, (std::vector<double>{0.0, 1.0 / 8000.0, 2.0 / 8000.0}));
    ASSERT_EQ(recording.values.size(), 2U);
    EXPECT_EQ(recording.values[0], (std::vector<float>{0.0F, -0.25F, 0.75F}));
    EXPECT_EQ(recording.values[1], (std::vector<float>{0.5F, 0.125F, -1.0F}));
    EXPECT_EQ(recording.rows_read, 3);
    EXPECT_FALSE(recording.damaged);
  }
}

TEST(PhotodiodeSound, CodesAreWholeWhereTheSiteScalesCounts) {
  const TemporaryFolder folder;
  const fs::path path =
      written(folder.path() / "a.wav", SF_FORMAT_WAV | SF_FORMAT_PCM_16, 1000, 1, kFractions);
  std::vector<PhotodiodeSite> diodes = photodiodes(1);
  diodes[0].volts_per_count = 1e-4;
  EXPECT_EQ(read_photodiode_sound(path, diodes).values[0],
            (std::vector<float>{0, 16384, -8192, 4096, 24576, -32768}));
}

TEST(PhotodiodeSound, FloatingPointIsAsWritten) {
  const TemporaryFolder folder;
  const std::vector<double> volts{0.0, 2.5, -0.5};
  const fs::path path =
      written(folder.path() / "a.wav", SF_FORMAT_WAV | SF_FORMAT_FLOAT, 48000, 1, volts);
  std::vector<PhotodiodeSite> diodes = photodiodes(1);
  diodes[0].volts_per_count = 1.0;
  EXPECT_EQ(read_photodiode_sound(path, diodes).values[0], (std::vector<float>{0.0F, 2.5F, -0.5F}));
}

TEST(PhotodiodeSound, AFileCutShortIsReadAsFarAsItGoes) {
  const TemporaryFolder folder;
  std::vector<double> fractions(20000);
  for (std::size_t i = 0; i < fractions.size(); ++i)
    fractions[i] = 0.5 * std::sin(0.01 * static_cast<double>(i));
  for (const int container : {SF_FORMAT_WAV, SF_FORMAT_FLAC}) {
    const fs::path path =
        written(folder.path() / "cut", container | SF_FORMAT_PCM_16, 1000, 1, fractions);
    fs::resize_file(path, fs::file_size(path) / 2);
    const PhotodiodeRecording recording = read_photodiode_sound(path, photodiodes(1));
    EXPECT_TRUE(recording.damaged) << container;
    EXPECT_GT(recording.rows_read, 1000) << container;
    EXPECT_LT(recording.rows_read, 20000) << container;
    ASSERT_EQ(recording.warnings.size(), 1U);
    EXPECT_NE(recording.warnings[0].find("before its header says"), std::string::npos);
    for (std::size_t i = 0; i < 1000; ++i)
      ASSERT_NEAR(recording.values[0][i], fractions[i], 1.0 / 32768.0);
  }
}

std::string error_of(const fs::path& path, std::size_t diodes) {
  try {
    read_photodiode_sound(path, photodiodes(diodes));
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

TEST(PhotodiodeSound, WhatDoesNotFitIsTold) {
  const TemporaryFolder folder;
  const fs::path path =
      written(folder.path() / "a.wav", SF_FORMAT_WAV | SF_FORMAT_PCM_16, 192000, 2, kFractions);
  EXPECT_NE(error_of(path, 2).find("192000 samples a second"), std::string::npos);
  written(path, SF_FORMAT_WAV | SF_FORMAT_PCM_16, 1000, 2, kFractions);
  EXPECT_NE(error_of(path, 1).find("2 channels"), std::string::npos);
  written(path, SF_FORMAT_WAV | SF_FORMAT_PCM_16, 1000, 1, {});
  EXPECT_NE(error_of(path, 1).find("no sample"), std::string::npos);
  std::ofstream(path) << "RIFF is how this text begins";
  EXPECT_TRUE(is_sound_file(path));
  EXPECT_NE(error_of(path, 1).find("a.wav: cannot be read as WAV or FLAC"), std::string::npos);
  std::ofstream(path) << "t_s,power_w\n0,1\n";
  EXPECT_FALSE(is_sound_file(path));
  EXPECT_FALSE(is_sound_file(folder.path() / "missing.wav"));
}

}  // namespace
}  // namespace vildar
