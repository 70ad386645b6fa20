#include "core/atomic_file.h"

#include <fcntl.h>
#include <signal.h>
#include <unistd.h>
#include <cerrno>
#include <charconv>
#include <chrono>
#include <cstring>
#include <system_error>
#include <utility>

#include "core/error.h"

namespace vildar {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail(const fs::path& path, const std::string& what, int error) {
  throw OutputError(path.string() + ": " + what + ": " + std::strerror(error) +
                    "; choose a folder that can be written and has space left");
}

void flush_to_disk(const fs::path& path) {
  const int descriptor = ::open(path.c_str(), O_RDONLY);
  if (descriptor < 0) fail(path, "cannot be reopened", errno);
  const int result = ::fsync(descriptor);
  const int error = errno;
  ::close(descriptor);
  if (result != 0) fail(path, "cannot be flushed to the disk", error);
}

// Siblings of the same file that a run left which was killed: of no process here, and, as a folder
// may be shared with other machines and containers, not written to for a day.
void remove_left_behind(const fs::path& folder, const fs::path& file) {
  constexpr auto kLongSince = std::chrono::hours(24);
  const std::string begin = "." + file.stem().string() + ".";
  const std::string end = ".part" + file.extension().string();
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(folder, ignored)) {
    const std::string name = entry.path().filename().string();
    if (name.size() <= begin.size() + end.size() || !name.starts_with(begin) ||
        !name.ends_with(end))
      continue;
    const char* last = name.data() + name.size() - end.size();
    pid_t process = 0;
    const auto [stop, error] = std::from_chars(name.data() + begin.size(), last, process);
    if (error != std::errc() || stop != last || process <= 0) continue;
    if (::kill(process, 0) == 0 || errno != ESRCH) continue;
    const auto written = entry.last_write_time(ignored);
    if (!ignored && fs::file_time_type::clock::now() - written > kLongSince)
      fs::remove(entry.path(), ignored);
  }
}

}  // namespace

AtomicFile::AtomicFile(fs::path path) : path_(std::move(path)) {
  const fs::path folder = path_.has_parent_path() ? path_.parent_path() : fs::path(".");
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) fail(folder, "folder cannot be made", error.value());
  if (const auto status = fs::status(path_, error);
      fs::exists(status) && !fs::is_regular_file(status))
    throw OutputError(path_.string() + ": is a folder, a device or a pipe; choose another name");
  remove_left_behind(folder, path_);
  // The extension stays last: libavformat picks the container by it.
  part_path_ = folder / ("." + path_.stem().string() + "." + std::to_string(::getpid()) + ".part" +
                         path_.extension().string());
  stream_.open(part_path_, std::ios::binary | std::ios::trunc);
  if (!stream_) fail(path_, "cannot be written", errno);
}

AtomicFile::AtomicFile(AtomicFile&& other) noexcept
    : path_(std::move(other.path_)),
      part_path_(std::move(other.part_path_)),
      stream_(std::move(other.stream_)),
      finished_(other.finished_),
      committed_(std::exchange(other.committed_, true)) {}

AtomicFile::~AtomicFile() {
  if (committed_) return;
  stream_.close();
  std::error_code ignored;
  fs::remove(part_path_, ignored);
}

void AtomicFile::write(std::string_view text) {
  errno = 0;
  stream_.write(text.data(), static_cast<std::streamsize>(text.size()));
  if (!stream_) fail(path_, "write failed", errno != 0 ? errno : EIO);
}

void AtomicFile::finish() {
  errno = 0;
  stream_.close();
  if (!stream_) fail(path_, "write failed", errno != 0 ? errno : EIO);
  flush_to_disk(part_path_);
  finished_ = true;
}

void AtomicFile::commit() {
  if (!finished_) finish();
  std::error_code error;
  fs::rename(part_path_, path_, error);
  if (error) fail(path_, "cannot be put in place", error.value());
  committed_ = true;
  flush_to_disk(part_path_.parent_path());
}

AtomicFile finished_file(const fs::path& path, std::string_view text) {
  AtomicFile file(path);
  file.write(text);
  file.finish();
  return file;
}

void write_file_atomically(const fs::path& path, std::string_view text) {
  finished_file(path, text).commit();
}

}  // namespace vildar
