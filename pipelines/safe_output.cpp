#include "pipelines/safe_output.h"

#include <system_error>

#include "core/error.h"

namespace vildar {

namespace fs = std::filesystem;

void refuse_to_replace(const fs::path& out, const std::string& extension,
                       const std::vector<fs::path>& read) {
  const bool as_before = out.extension() == extension && out.filename() != "run.json";
  for (const fs::path& input : read) {
    std::error_code error;
    const bool within = fs::is_directory(input, error) && !as_before &&
                        fs::equivalent(input / out.filename(), out, error);
    if (within || fs::equivalent(input, out, error))
      throw ConfigError({{out.string(), 0, "",
                          "is read, or stands in a folder that is read and is not of this command",
                          "choose another --out"}});
  }
}

}  // namespace vildar
