#pragma once

#include <filesystem>
#include <fstream>
#include <string_view>

namespace vildar {

/// A file that appears whole under its name, or not at all. Bytes go to a hidden sibling
/// `.STEM.PID.part.EXT`; `finish()` flushes it to the disk, `commit()` renames it and flushes the
/// folder. Files that belong together are finished all before the first is committed: a disk that
/// is full then leaves none of them. Destroyed without commit, the sibling is removed and what
/// stood under the name before stays. Every failure (folder missing, read-only, disk full, a
/// folder or a device under that name) throws OutputError naming the file.
class AtomicFile {
 public:
  /// Creates the missing parent folders.
  explicit AtomicFile(std::filesystem::path path);
  ~AtomicFile();
  AtomicFile(AtomicFile&& other) noexcept;
  AtomicFile& operator=(AtomicFile&&) = delete;

  /// Buffered; a failed write is reported here or, at the latest, by finish().
  void write(std::string_view text);
  /// Nothing may be written after it.
  void finish();
  /// Finishes what is not finished yet.
  void commit();
  const std::filesystem::path& path() const { return path_; }
  /// For writers that open the file themselves (libavformat): write here, then call finish().
  const std::filesystem::path& part_path() const { return part_path_; }

 private:
  std::filesystem::path path_;
  std::filesystem::path part_path_;
  std::ofstream stream_;
  bool finished_ = false;
  bool committed_ = false;  ///< or moved from
};

/// `text` as the file `path` is to be, finished and not yet committed.
[[nodiscard]] AtomicFile finished_file(const std::filesystem::path& path, std::string_view text);

/// Writes `text` to `path`, whole or not at all.
void write_file_atomically(const std::filesystem::path& path, std::string_view text);

}  // namespace vildar
