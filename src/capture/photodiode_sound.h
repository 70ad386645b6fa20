#pragma once

#include <filesystem>
#include <span>

#include "types/power.h"
#include "types/site.h"

namespace vildar {

/// Whether a file begins as a WAV (RIFF, RIFX, RF64) or FLAC recording does. False where it cannot
/// be read.
bool is_sound_file(const std::filesystem::path& path);

/// Reads a WAV or FLAC recording: one channel for each photodiode, in the order of the site file;
/// times count from 0 at the file's own rate, so that a photodiode's time_offset_s says when it
/// began. Values are counts: whole codes of the converter for a photodiode with `volts_per_count`,
/// else fractions of full scale, -1 to 1. Samples of a floating-point file are as written.
///
/// A file that ends before its header says is read as far as it goes and sets `damaged`. Throws
/// InputError where the file cannot be opened or holds no sample, where it has more channels than
/// there are photodiodes, or a rate outside 100 Hz to 100 kHz.
PhotodiodeRecording read_photodiode_sound(const std::filesystem::path& path,
                                          std::span<const PhotodiodeSite> photodiodes);

}  // namespace vildar
