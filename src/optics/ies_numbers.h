#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace vildar {

/// The numbers of a photometric file one after the other, across lines, with messages that name the
/// line. Blanks, commas and the end-of-file mark of old systems part them.
class IesNumbers {
 public:
  /// `first_line` is the number of the line that `text` begins with. The text must outlive this.
  IesNumbers(std::filesystem::path file, std::string_view text, int first_line);

  /// `what` says in a message which number was expected. Throws InputError where it is missing or
  /// is no finite number; `whole` also where it is not a whole number in [least, most].
  double next(const std::string& what);
  std::size_t whole(const std::string& what, double least, double most);
  std::vector<double> several(const std::string& what, std::size_t count);
  /// Throws InputError where something is left.
  void expect_end();

  /// Throws InputError for the place of the number read last.
  [[noreturn]] void fail(const std::string& fault, const std::string& remedy) const;

 private:
  std::string_view next_word();
  std::filesystem::path file_;
  std::string_view text_;
  int line_;
};

}  // namespace vildar
