#pragma once

#include <span>
#include <string>
#include <string_view>

namespace vildar {

/// Shortest decimal text that reads back as the same double; "nan" and "inf" never appear in our
/// files, so non-finite values give an empty text (an empty cell).
std::string number_text(double value);

/// The same for messages, in which what is not finite has its name.
std::string told_number(double value);

/// `value` with a fixed number of digits after the point; empty where it is not finite.
std::string fixed_text(double value, int digits);

/// `text` without blanks, tabs and carriage returns at either end.
std::string_view trimmed(std::string_view text);

/// The candidate with the smallest edit distance to `name`, or empty where none is near enough
/// (more than a third of its letters, and more than 2, differ).
std::string_view nearest_name(std::string_view name, std::span<const std::string_view> candidates);

}  // namespace vildar
