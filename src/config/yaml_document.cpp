#include "config/yaml_document.h"

#include <cerrno>
#include <cstring>
#include <fstream>
#include <iterator>
#include <map>
#include <sstream>
#include <system_error>
#include <utility>

#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/exceptions.h>
#include <yaml-cpp/parser.h>

#include "core/error.h"

namespace vildar {
namespace {

namespace fs = std::filesystem;
using Kind = YamlNode::Kind;

[[noreturn]] void fail(const std::string& file, int line, std::string fault, std::string remedy) {
  throw ConfigError({Problem{file, line, "", std::move(fault), std::move(remedy)}});
}

/// Builds the tree from the parser's events and stops at the first sign of a file that is not meant
/// for us, before the memory for it is taken.
class TreeBuilder : public YAML::EventHandler {
 public:
  explicit TreeBuilder(std::string file) : file_(std::move(file)) {}
  std::shared_ptr<const YamlNode> root() const { return root_; }

  void OnDocumentStart(const YAML::Mark& mark) override {
    if (root_) fail(file_, line_of(mark), "a second document begins", "keep one document per file");
  }
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    open(Kind::null, mark, "", anchor);
    close();
  }
  void OnScalar(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                const std::string& value) override {
    open(Kind::scalar, mark, tag, anchor);
    const std::shared_ptr<YamlNode>& node = open_.back().node;
    node->scalar = value;
    node->quoted = tag == "!";
    if (!node->quoted && (value == "~" || value == "null")) node->kind = Kind::null;
    close();
  }
  void OnAlias(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    const auto found = anchored_.find(anchor);
    if (found == anchored_.end())
      fail(file_, line_of(mark), "an alias (*name) inside the value it stands for",
           "write the value out");
    attach(found->second, line_of(mark));
  }
  void OnSequenceStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                       YAML::EmitterStyle::value) override {
    open(Kind::list, mark, tag, anchor);
  }
  void OnSequenceEnd() override { close(); }
  void OnMapStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                  YAML::EmitterStyle::value) override {
    open(Kind::map, mark, tag, anchor);
  }
  void OnMapEnd() override { close(); }

 private:
  struct Open {
    std::shared_ptr<YamlNode> node;
    YAML::anchor_t anchor = 0;
    bool has_key = false;  // of a map: a key waits for its value
    YamlEntry entry;
  };

  static int line_of(const YAML::Mark& mark) { return mark.line + 1; }

  void open(Kind kind, const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor) {
    if (!tag.empty() && tag != "?" && tag != "!")
      fail(file_, line_of(mark), "the tag " + tag.substr(0, 60) + " is not known here",
           "remove the tag");
    Open next;
    next.node = std::make_shared<YamlNode>();
    next.node->kind = kind;
    next.node->line = line_of(mark);
    next.anchor = anchor;
    open_.push_back(std::move(next));
  }

  void close() {
    const Open done = std::move(open_.back());
    open_.pop_back();
    if (done.anchor != 0) anchored_[done.anchor] = done.node;
    attach(done.node, done.node->line);
  }

  void attach(std::shared_ptr<const YamlNode> node, int line) {
    if (open_.empty()) {
      root_ = std::move(node);
      return;
    }
    Open& parent = open_.back();
    // Nodes count towards every level above them only when closed, so each level is checked here.
    parent.node->expanded_nodes += node->expanded_nodes;
    nodes_ += 1;
    if (nodes_ > kMostYamlNodes || parent.node->expanded_nodes > kMostYamlNodes)
      fail(file_, line,
           "more than " + std::to_string(kMostYamlNodes) + " values, counting what aliases repeat",
           "give a site or scenario file; these have some dozens");
    if (parent.node->kind == Kind::list) {
      parent.node->items.push_back(std::move(node));
    } else if (parent.has_key) {
      parent.entry.value = std::move(node);
      parent.node->entries.push_back(std::move(parent.entry));
      parent.has_key = false;
    } else {
      if (node->kind != Kind::scalar)
        fail(file_, line, "a key that is not a name", "write `name: value`");
      parent.entry = {node->scalar, node->line, nullptr};
      parent.has_key = true;
    }
  }

  std::string file_;
  std::vector<Open> open_;
  std::map<YAML::anchor_t, std::shared_ptr<const YamlNode>> anchored_;
  std::shared_ptr<const YamlNode> root_;
  std::size_t nodes_ = 0;
};

}  // namespace

std::shared_ptr<const YamlNode> parse_yaml_text(std::string_view text, const std::string& file) {
  if (text.size() > kLargestYaml_bytes)
    fail(file, 0, "is larger than " + std::to_string(kLargestYaml_bytes >> 20) + " MB",
         "give a YAML file that a person wrote");
  if (text.find('\0') != std::string_view::npos)
    fail(file, 0, "is not a text file", "give a YAML file in UTF-8");
  TreeBuilder builder(file);
  try {
    std::istringstream stream{std::string(text)};
    YAML::Parser parser(stream);
    while (parser.HandleNextDocument(builder)) {
    }
  } catch (const YAML::Exception& error) {
    fail(file, error.mark.is_null() ? 0 : error.mark.line + 1,
         "is not valid YAML here (" + error.msg + ")", "check indentation, brackets and quotes");
  }
  if (!builder.root() || builder.root()->kind == Kind::null)
    fail(file, 0, "is empty", "write at least `version: 1` and what the file is to describe");
  return builder.root();
}

std::shared_ptr<const YamlNode> parse_yaml_file(const fs::path& file) {
  const std::string name = file.string();
  std::error_code error;
  const fs::file_status status = fs::status(file, error);
  if (status.type() == fs::file_type::not_found) fail(name, 0, "does not exist", "check the path");
  if (error) fail(name, 0, "cannot be read: " + error.message(), "check path and permissions");
  if (status.type() == fs::file_type::directory)
    fail(name, 0, "is a folder", "give the YAML file inside it");
  if (status.type() != fs::file_type::regular)
    fail(name, 0, "is not a plain file", "give a YAML file");
  const std::uintmax_t size_bytes = fs::file_size(file, error);
  if (!error && size_bytes > kLargestYaml_bytes)
    fail(name, 0,
         "has " + std::to_string(size_bytes) + " bytes; the limit is " +
             std::to_string(kLargestYaml_bytes),
         "give a YAML file that a person wrote");
  errno = 0;
  std::ifstream stream(file, std::ios::binary);
  const std::string text((std::istreambuf_iterator<char>(stream)), {});
  if (!stream.is_open() || stream.bad())
    fail(name, 0, std::string("cannot be read: ") + std::strerror(errno != 0 ? errno : EIO),
         "check the permissions");
  return parse_yaml_text(text, name);
}

}  // namespace vildar
