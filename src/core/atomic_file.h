#pragma once

#include <filesystem>
#include <fstream>
#include <string_view>

namespace vildar {

/// A file that appears whole under its name, or not at all. Bytes go to a hidden sibling
/// `.STEM.PID.part.EXT`; `commit()` flushes it to the disk, renames it and flushes the folder.
/// Destroyed without commit, the sibling is removed and what stood under the name before stays.
/// Every failure (folder missing, read-only, disk full) throws OutputError naming the file.
class AtomicFile {
 public:
  /// Creates the missing parent folders.
  explicit AtomicFile(std::filesystem::path path);
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  /// Buffered; a failed write is reported here or, at the latest, by commit().
  void write(std::string_view text);
  void commit();
  const std::filesystem::path& path() const { return path_; }
  /// For writers that open the file themselves (libavformat): write here, then call commit().
  const std::filesystem::path& part_path() const { return part_path_; }

 private:
  std::filesystem::path path_;
  std::filesystem::path part_path_;
  std::ofstream stream_;
  bool committed_ = false;
};

/// Writes `text` to `path`, whole or not at all.
void write_file_atomically(const std::filesystem::path& path, std::string_view text);

}  // namespace vildar
