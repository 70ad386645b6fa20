#pragma once

#include <filesystem>
#include <span>

#include "core/atomic_file.h"
#include "sink/csv_row.h"
#include "types/blob.h"
#include "types/result.h"

namespace vildar {

// The tables of a run (columns and units: docs/outputs.md), finished and not yet committed: a run's
// files appear together. Every failure to write throws OutputError.

/// speeds.csv, one row per vehicle. A withheld row has `withheld:REASON` as its status and no time
/// of reference, speed, range, acceleration or method.
[[nodiscard]] AtomicFile write_speeds(const std::filesystem::path& path,
                                      std::span<const VehicleResult> vehicles);

/// methods.csv, one row per vehicle and method that applied.
[[nodiscard]] AtomicFile write_methods(const std::filesystem::path& path,
                                       std::span<const VehicleResult> vehicles);

/// tracks.csv, in the order in which rows are added.
class TracksWriter {
 public:
  explicit TracksWriter(const std::filesystem::path& path);
  void add(std::span<const TrackRow> rows);
  [[nodiscard]] AtomicFile finish() &&;

 private:
  AtomicFile file_;
  CsvRow row_;
};

/// blobs.csv, frame by frame.
class BlobsWriter {
 public:
  explicit BlobsWriter(const std::filesystem::path& path);
  void add(const BlobFrame& frame);
  [[nodiscard]] AtomicFile finish() &&;

 private:
  AtomicFile file_;
  CsvRow row_;
};

}  // namespace vildar
