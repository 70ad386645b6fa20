#include "config/site_file.h"
#include "core/error.h"
#include "fuzz/fuzz_input.h"

namespace {

vildar::Site site_in(const std::string& text, const std::filesystem::path& file) {
  const vildar::YamlReader reader(text, file);
  reader.root().find("version");
  vildar::Site site = vildar::read_site(reader.root());
  reader.finish();
  return site;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::filesystem::path file = vildar::fuzz::file_with(data, size);
  vildar::Site site;
  try {
    site = vildar::load_site(file);
  } catch (const vildar::ConfigError& error) {
    vildar::fuzz::require(!error.problems().empty(), "a refusal says what is wrong");
    return 0;
  }
  vildar::Site again = site_in(vildar::effective_site_yaml(site), file);
  again.file = site.file;
  vildar::fuzz::require(again == site, "the effective settings read back as the same site");
  return 0;
}
