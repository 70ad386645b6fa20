#include "evaluate/csv_reader.h"

#include <gtest/gtest.h>

#include "core/error.h"
#include "support/temporary_folder.h"

namespace vildar {
namespace {

std::string fault_of(const auto& action) {
  try {
    action();
  } catch (const InputError& error) {
    return error.what();
  }
  return "no fault";
}

void expect_in(const std::string& text, const std::string& part) {
  EXPECT_NE(text.find(part), std::string::npos) << text << " lacks " << part;
}

TEST(CsvReader, FindsColumnsByNameWhateverTheirOrder) {
  const TemporaryFolder folder;
  const auto file =
      folder.write("a.csv", "# made by hand\nb,extra,a\r\n\n2,\"x,\"\"y\"\"\",-1.5e1\n,,7\n");
  CsvReader csv(file, {"a", "b"});
  ASSERT_TRUE(csv.next());
  EXPECT_EQ(csv.number("a"), -15.0);
  EXPECT_EQ(csv.integer("b"), 2);
  EXPECT_EQ(csv.text("extra"), "x,\"y\"");
  EXPECT_EQ(csv.optional_number("absent"), std::nullopt);
  ASSERT_TRUE(csv.next());
  EXPECT_EQ(csv.optional_number("b"), std::nullopt);
  EXPECT_EQ(csv.number("a"), 7.0);
  EXPECT_FALSE(csv.next());
}

TEST(CsvReader, FaultsNameFileLineAndColumn) {
  const TemporaryFolder folder;
  const auto file = folder.write("bad.csv", "a,b\n1,2\nfast,inf\n,1.5\n");
  CsvReader csv(file, {"a"});
  csv.next();
  csv.next();
  const std::string number = fault_of([&] { csv.number("a"); });
  expect_in(number, "bad.csv:3: column a: ");
  expect_in(number, "\"fast\"");
  expect_in(fault_of([&] { csv.optional_number("b"); }), "not a finite number");
  csv.next();
  expect_in(fault_of([&] { csv.number("a"); }), "bad.csv:4: column a: is empty");
  expect_in(fault_of([&] { csv.integer("b"); }), "\"1.5\" is not a whole number");
}

TEST(CsvReader, RefusesFilesThatAreNotTables) {
  const TemporaryFolder folder;
  const auto open = [&](const char* text) {
    return fault_of([&, file = folder.write("t.csv", text)] {
      CsvReader csv(file, {"a"});
      while (csv.next()) {
      }
    });
  };
  expect_in(open(""), "has no header line");
  expect_in(open("b\n1\n"), "column a: is missing");
  expect_in(open("a,a\n1,2\n"), "stands twice");
  expect_in(open("a,b\n1,2\n3\n"), ":3: has 1 cells, the header names 2");
  expect_in(open("a,b\n\"1,2\n"), ":2: a quote is not closed");
  expect_in(fault_of([&] { CsvReader(folder.path() / "absent.csv", {}); }), "cannot be opened");
  expect_in(fault_of([&] { CsvReader(folder.path(), {}); }), "cannot be opened");
}

}  // namespace
}  // namespace vildar
