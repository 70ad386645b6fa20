#pragma once

#include <filesystem>
#include <span>

#include "core/atomic_file.h"
#include "sink/csv_row.h"
#include "types/blob.h"
#include "types/result.h"

namespace vildar {

// The tables of a run (columns and units: docs/outputs.md). Each file appears whole or not at all;
// every failure to write throws OutputError.

/// speeds.csv, one row per vehicle. A withheld row has `withheld:REASON` as its status and no time
/// of reference, speed, range, acceleration or method.
void write_speeds(const std::filesystem::path& path, std::span<const VehicleResult> vehicles);

/// methods.csv, one row per vehicle and method that applied.
void write_methods(const std::filesystem::path& path, std::span<const VehicleResult> vehicles);

/// tracks.csv, in the order in which rows are added; nothing stands under the name before commit().
class TracksWriter {
 public:
  explicit TracksWriter(const std::filesystem::path& path);
  void add(std::span<const TrackRow> rows);
  void commit();

 private:
  AtomicFile file_;
  CsvRow row_;
};

/// blobs.csv, frame by frame; nothing stands under the name before commit().
class BlobsWriter {
 public:
  explicit BlobsWriter(const std::filesystem::path& path);
  void add(const BlobFrame& frame);
  void commit();

 private:
  AtomicFile file_;
  CsvRow row_;
};

}  // namespace vildar
