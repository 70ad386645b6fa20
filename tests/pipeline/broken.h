#pragma once

#include <gtest/gtest.h>

#include <string>

#include "core/text.h"
#include "support/clip_writer.h"
#include "support/file_bytes.h"
#include "support/program.h"

namespace vildar {

/// Whole runs of the program on input that is not as it should be.
class Broken : public ::testing::Test {
 protected:
  using Words = std::vector<std::string>;

  /// `vildar run` with these words and an output folder of its own.
  test::Ran run(Words words) const {
    words.insert(words.begin(), "run");
    words.insert(words.end(), {"--out", out().string()});
    return test::Program(VILDAR_PROGRAM, words, folder_.path()).wait();
  }
  std::filesystem::path out() const { return folder_.path() / "out"; }
  std::filesystem::path path(const std::string& name) const { return folder_.path() / name; }
  std::string run_json() const { return test::bytes_of(out() / "run.json"); }

  /// A site for clips of the given size, with one photodiode.
  std::string site(int width_px = 64, int height_px = 48) const {
    const std::string size =
        "[" + std::to_string(width_px) + ", " + std::to_string(height_px) + "]";
    const std::string centre =
        "[" + number_text(0.5 * (width_px - 1)) + ", " + number_text(0.5 * (height_px - 1)) + "]";
    return write("site.yaml",
                 "version: 1\ncamera:\n  image_size_px: " + size +
                     "\n  focal_px: [60, 60]\n  principal_px: " + centre +
                     "\n  position_m: [0, 0, 5]\n  pitch_deg: -4\n"
                     "photodiode: {position_m: [0, 0, 5]}\n"
                     "road:\n  kind: straight\n  lanes:\n"
                     "    - {id: near, lateral_m: -4, width_m: 3.5, direction: oncoming}\n"
                     "lamps: {height_m: 0.68, separation_m: 1.25}\n");
  }
  std::string write(const std::string& name, const std::string& bytes) const {
    test::write_bytes(path(name), bytes);
    return path(name).string();
  }
  /// A clip of frames that differ, and its path.
  std::string clip(test::ClipSpec spec) const {
    test::write_clip(spec, test::index_painter());
    return spec.path.string();
  }

  TemporaryFolder folder_;
};

inline const std::vector<std::string> kOutputs{"methods.csv", "report.html", "run.json",
                                               "speeds.csv", "tracks.csv"};

inline std::filesystem::path sample(const std::string& name) {
  return std::filesystem::path(VILDAR_SOURCE_DIR) / "data_samples" / name;
}

}  // namespace vildar
