#include "optics/ies_numbers.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <utility>

#include "core/error.h"
#include "core/text.h"

namespace vildar {
namespace {

constexpr std::string_view kSeparators = " \t\r\n,\x1a";

}  // namespace

IesNumbers::IesNumbers(std::filesystem::path file, std::string_view text, int first_line)
    : file_(std::move(file)), text_(text), line_(first_line) {}

std::string_view IesNumbers::next_word() {
  const std::size_t start = std::min(text_.find_first_not_of(kSeparators), text_.size());
  line_ += static_cast<int>(
      std::count(text_.begin(), text_.begin() + static_cast<std::ptrdiff_t>(start), '\n'));
  text_.remove_prefix(start);
  const std::string_view word = text_.substr(0, text_.find_first_of(kSeparators));
  text_.remove_prefix(word.size());
  return word;
}

double IesNumbers::next(const std::string& what) {
  const std::string_view word = next_word();
  if (word.empty()) fail("the file ends where " + what + " should stand", "get the whole file");
  const std::string_view digits = word.front() == '+' ? word.substr(1) : word;
  double value = 0.0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  if (error != std::errc() || end != digits.data() + digits.size() || !std::isfinite(value))
    fail("\"" + std::string(word) + "\" stands where " + what + " should",
         "write a finite number there");
  return value;
}

std::size_t IesNumbers::whole(const std::string& what, double least, double most) {
  const double value = next(what);
  if (value != std::floor(value) || value < least || value > most)
    fail(what + " is " + number_text(value),
         "it must be a whole number from " + number_text(least) + " to " + number_text(most));
  return static_cast<std::size_t>(value);
}

std::vector<double> IesNumbers::several(const std::string& what, std::size_t count) {
  std::vector<double> values;
  values.reserve(count);
  for (std::size_t i = 0; i < count; ++i)
    values.push_back(next(what + " " + std::to_string(i + 1) + " of " + std::to_string(count)));
  return values;
}

void IesNumbers::expect_end() {
  const std::string_view word = next_word();
  if (!word.empty())
    fail("\"" + std::string(word) + "\" stands after the last intensity",
         "the numbers of angles in the line after TILT do not match the table: correct them");
}

void IesNumbers::fail(const std::string& fault, const std::string& remedy) const {
  throw InputError(file_.string() + ":" + std::to_string(line_) + ": " + fault + "; " + remedy);
}

}  // namespace vildar
