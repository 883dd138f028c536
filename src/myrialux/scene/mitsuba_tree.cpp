// Builds the tree of a Mitsuba XML scene: nesting, defaults, includes, aliases, references, positions.
// Syntax as Mitsuba 0.5/0.6 and 2/3 have it; names of the older dialect are upgraded, messages keep the old spelling.
#include "myrialux/scene/mitsuba_tree.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <pugixml.hpp>
#include <set>

#include "myrialux/base/suggest.h"
#include "myrialux/scene/mitsuba_values.h"
#include "myrialux/scene/text.h"

namespace myrialux::mitsuba {

namespace {

const std::vector<std::string> kObjectTags = {"bsdf",      "shape",  "emitter",    "sensor", "film",    "sampler",
                                              "rfilter",   "medium", "phase",      "volume", "texture", "integrator",
                                              "luminaire", "camera", "subsurface", "bsphere"};
constexpr std::size_t kMaxDepth = 100;  ///< objects within objects

const std::vector<std::string> kStructureTags = {"ref", "alias", "include", "default", "path", "scene"};

/// One file that is being read.
struct File {
  std::string path;
  std::filesystem::path folder;
  LineTable lines;
  bool old_names = false;  ///< camelCase dialect
  TextPosition at(const pugi::xml_node& node) const {
    const std::ptrdiff_t offset = node.offset_debug();
    return lines.at(offset > 0 ? static_cast<std::size_t>(offset - 1) : 0);
  }
};

class TreeReader {
 public:
  TreeReader(Tree& tree, const LoadOptions& options, Diagnostics& found)
      : tree_(tree), options_(options), found_(found), defines_(options.defines) {}
  void read(const std::string& path);

 private:
  void read_file_into(Object& scene, const std::string& path, const TextPosition& named_at);
  void read_children(Object& owner, const pugi::xml_node& node, const File& file, bool is_top);
  void read_structure(Object& owner, const pugi::xml_node& node, const File& file, bool is_top);
  void read_object(Object& owner, const pugi::xml_node& node, const File& file);
  void read_include(Object& owner, const pugi::xml_node& node, const File& file);
  void substitute(pugi::xml_node node, const File& file);
  void substitute_within(const pugi::xml_node& node, const File& file);
  std::string substitute(const std::string& text, const TextPosition& at);
  void remember(const std::string& id, Object* object, const TextPosition& at);
  void link();
  void cut_cycles(Object& object, std::set<const Object*>& open, std::set<const Object*>& done);
  void report_unused_defines();

  Tree& tree_;
  const LoadOptions& options_;
  Diagnostics& found_;
  std::map<std::string, std::string> defines_;
  std::set<std::string> used_defines_;
  std::map<std::string, std::pair<Object*, TextPosition>> ids_;
  std::vector<std::pair<std::string, std::pair<std::string, TextPosition>>> aliases_;  ///< as -> id
  std::vector<std::string> open_files_;                                                ///< chain of includes
  std::size_t depth_ = 0;                                                              ///< of the object being read
};

std::string attribute(const pugi::xml_node& node, const char* name) { return node.attribute(name).as_string(); }

}  // namespace

Tree read_tree(const std::string& path, const LoadOptions& options, Diagnostics& found) {
  Tree tree;
  tree.objects.emplace_back();
  tree.objects.front().tag = "scene";
  tree.objects.front().at = {path, 0, 0};
  TreeReader(tree, options, found).read(path);
  return tree;
}

std::filesystem::path resolve(const Tree& tree, const std::filesystem::path& folder, const std::string& name) {
  std::filesystem::path file(name);
  if (file.is_absolute()) return file;
  std::error_code code;
  std::filesystem::path beside = folder / file;
  if (std::filesystem::exists(beside, code)) return beside;
  for (const std::filesystem::path& path : tree.search_paths)
    if (std::filesystem::exists(path / file, code)) return path / file;
  const std::filesystem::path beside_scene = tree.scene().folder / file;
  return std::filesystem::exists(beside_scene, code) ? beside_scene : beside;
}

std::string to_snake_case(const std::string& name) {
  std::string snake;
  for (std::size_t i = 0; i < name.size(); ++i) {
    const unsigned char c = static_cast<unsigned char>(name[i]);
    const bool starts_word = std::isupper(c) && i > 0 &&
                             (std::islower(static_cast<unsigned char>(name[i - 1])) ||
                              std::isdigit(static_cast<unsigned char>(name[i - 1])));
    if (starts_word) snake += '_';
    snake += static_cast<char>(std::tolower(c));
  }
  return snake;
}

std::string suggestion(const std::string& name, const std::vector<std::string>& allowed) {
  if (name.size() > 200) return {};  // not a misspelt name
  const std::string best = nearest_name(name, allowed);
  return best.empty() ? "" : "; did you mean \"" + best + "\"?";
}

namespace {

void TreeReader::read(const std::string& path) {
  tree_.objects.front().folder = std::filesystem::path(path).parent_path();
  read_file_into(tree_.objects.front(), path, {path, 0, 0});
  link();
  report_unused_defines();
}

void TreeReader::read_file_into(Object& scene, const std::string& path, const TextPosition& named_at) {
  std::optional<std::string> text = read_file(path);
  if (!text)
    return found_.error(named_at, open_files_.empty() ? "cannot be read; check that the file exists"
                                                      : "cannot read included file \"" + path + "\"");
  if (text->starts_with("\xef\xbb\xbf")) text->erase(0, 3);
  File file{path, std::filesystem::path(path).parent_path(), LineTable(path, *text), false};
  pugi::xml_document document;
  const pugi::xml_parse_result result =
      document.load_buffer(text->data(), text->size(), pugi::parse_default, pugi::encoding_utf8);
  if (!result)
    return found_.error(file.lines.at(static_cast<std::size_t>(std::max<std::ptrdiff_t>(result.offset, 0))),
                        std::string("not well-formed XML: ") + result.description());
  tree_.texts.push_back(*text);
  const pugi::xml_node root = document.document_element();
  if (std::string(root.name()) != "scene")
    return found_.error(file.at(root), fmt::format("root element is <{}>; allowed: <scene>", root.name()));
  if (scene.at.line == 0 && open_files_.empty()) scene.at = file.at(root);
  const std::string version = attribute(root, "version");
  if (version.empty())
    found_.warning(file.at(root), "<scene> has no version; read as version 3.0.0");
  else if (!std::isdigit(static_cast<unsigned char>(version[0])))
    found_.error(file.at(root), "version \"" + version + "\" is not a version number such as \"3.0.0\"");
  file.old_names = version.starts_with("0.") || version.starts_with("1.");
  open_files_.push_back(path);
  read_children(scene, root, file, true);
  open_files_.pop_back();
}

void TreeReader::read_children(Object& owner, const pugi::xml_node& node, const File& file, bool is_top) {
  for (pugi::xml_node child : node.children()) {
    if (child.type() == pugi::node_pcdata || child.type() == pugi::node_cdata) {
      found_.error(file.at(node), fmt::format("<{}> holds text; allowed: elements and attributes", node.name()));
      continue;
    }
    if (child.type() != pugi::node_element) continue;
    substitute(child, file);
    const std::string tag = child.name();
    const auto is_in = [&](const std::vector<std::string>& tags) {
      return std::find(tags.begin(), tags.end(), tag) != tags.end();
    };
    if (is_in(kStructureTags)) {
      read_structure(owner, child, file, is_top);
    } else if (is_in(kObjectTags)) {
      read_object(owner, child, file);
    } else if (is_property_tag(tag)) {
      substitute_within(child, file);
      PropertyContext context{file.old_names, [&](const pugi::xml_node& n) { return file.at(n); }, found_};
      if (std::optional<Property> property = read_property(child, context)) {
        if (!property->name.empty()) {
          for (const Property& other : owner.properties)
            if (other.name == property->name)
              found_.error(property->at, fmt::format("property \"{}\" is given twice; first at {}", property->spelled,
                                                     to_string(other.at)));
        }
        if (const auto* animation = std::get_if<Animation>(&property->value); animation && owner.tag != "sensor") {
          found_.unsupported(
              property->at,
              fmt::format("a moving {} cannot be rendered yet; allowed: <animation> in a sensor", owner.tag));
          property->value = Transform(animation->keys.front().to_world);
        }
        owner.properties.push_back(std::move(*property));
      }
    } else {
      std::vector<std::string> all = kObjectTags;
      all.insert(all.end(), kStructureTags.begin(), kStructureTags.end());
      for (const std::string& name : property_tags()) all.push_back(name);
      found_.error(file.at(child), fmt::format("unknown element <{}>{}", tag, suggestion(tag, all)));
    }
  }
}

void TreeReader::read_structure(Object& owner, const pugi::xml_node& node, const File& file, bool is_top) {
  const std::string tag = node.name();
  const TextPosition at = file.at(node);
  const auto require = [&](const char* name) {
    if (!attribute(node, name).empty()) return true;
    found_.error(at, fmt::format("<{}> needs the attribute {}", tag, name));
    return false;
  };
  if (tag == "ref") {
    if (!require("id")) return;
    const std::string name = attribute(node, "name");
    owner.children.push_back({file.old_names ? to_snake_case(name) : name, name, attribute(node, "id"), at});
    return;
  }
  if (!is_top) return found_.error(at, fmt::format("<{}> is allowed at the top of the scene only", tag));
  if (tag == "include") {
    if (require("filename")) read_include(owner, node, file);
  } else if (tag == "default") {
    if (require("name")) defines_.emplace(attribute(node, "name"), attribute(node, "value"));
  } else if (tag == "path") {
    if (!require("value")) return;
    const std::filesystem::path folder = file.folder / attribute(node, "value");
    std::error_code code;
    if (!std::filesystem::is_directory(folder, code))
      return found_.error(at, "path \"" + attribute(node, "value") + "\" is not a folder");
    tree_.search_paths.insert(tree_.search_paths.begin(), folder);
  } else if (tag == "alias") {
    if (require("id") && require("as")) aliases_.push_back({attribute(node, "as"), {attribute(node, "id"), at}});
  } else {
    found_.error(at, "<scene> inside a scene; allowed: one <scene> a file");
  }
}

void TreeReader::read_include(Object& owner, const pugi::xml_node& node, const File& file) {
  const std::string name = attribute(node, "filename");
  const std::string path = resolve(tree_, file.folder, name).lexically_normal().string();
  const auto is_same = [&](const std::string& other) {
    std::error_code code;
    return other == path || std::filesystem::equivalent(other, path, code);
  };
  const auto first = std::find_if(open_files_.begin(), open_files_.end(), is_same);
  if (first != open_files_.end()) {
    std::string chain;
    for (auto f = first; f != open_files_.end(); ++f) chain += *f + " -> ";
    return found_.error(file.at(node), "files include each other: " + chain + path);
  }
  if (open_files_.size() > 64) return found_.error(file.at(node), "includes nest deeper than 64 files");
  std::error_code code;
  if (!std::filesystem::exists(path, code))
    return found_.error(file.at(node), "included file \"" + name + "\" does not exist (looked for " + path + ")");
  read_file_into(owner, path, file.at(node));
}

void TreeReader::read_object(Object& owner, const pugi::xml_node& node, const File& file) {
  Object& object = tree_.objects.emplace_back();
  object.tag = node.name();
  if (object.tag == "luminaire") object.tag = "emitter";
  if (object.tag == "camera") object.tag = "sensor";
  object.spelled_type = attribute(node, "type");
  object.type = object.spelled_type;
  object.id = attribute(node, "id");
  object.at = file.at(node);
  object.folder = file.folder;
  object.old_dialect = file.old_names;
  for (const pugi::xml_attribute& a : node.attributes())
    if (const std::string name = a.name(); name != "type" && name != "id" && name != "name")
      found_.error(object.at,
                   fmt::format("<{}> has an unknown attribute {}; allowed: type, id, name", node.name(), name));
  if (object.type.empty()) found_.error(object.at, fmt::format("<{}> needs the attribute type", node.name()));
  if (!object.id.empty()) remember(object.id, &object, object.at);
  const std::string name = attribute(node, "name");
  owner.children.push_back({file.old_names ? to_snake_case(name) : name, name, "", object.at, &object});
  if (++depth_ > kMaxDepth)
    found_.error(object.at, fmt::format("elements nest deeper than {} levels", kMaxDepth));
  else
    read_children(object, node, file, false);
  --depth_;
}

void TreeReader::remember(const std::string& id, Object* object, const TextPosition& at) {
  const auto [place, is_new] = ids_.try_emplace(id, object, at);
  if (!is_new)
    found_.error(at, fmt::format("id \"{}\" is given twice; first at {}", id, to_string(place->second.second)));
}

/// Replaces $name in all attributes of a node, in place.
void TreeReader::substitute(pugi::xml_node node, const File& file) {
  for (pugi::xml_attribute a : node.attributes()) {
    const std::string text = a.value();
    if (text.find('$') != std::string::npos) a.set_value(substitute(text, file.at(node)).c_str());
  }
}

/// Transforms, animations and typed spectra have elements of their own, which name parameters too.
void TreeReader::substitute_within(const pugi::xml_node& node, const File& file) {
  for (pugi::xml_node part : node.children())
    if (part.type() == pugi::node_element) {
      substitute(part, file);
      for (pugi::xml_node step : part.children())
        if (step.type() == pugi::node_element) substitute(step, file);
    }
}

std::string TreeReader::substitute(const std::string& text, const TextPosition& at) {
  std::string result;
  for (std::size_t i = 0; i < text.size();) {
    if (text[i] != '$') {
      result += text[i++];
      continue;
    }
    const std::string* best = nullptr;  // the longest name that matches
    for (const auto& [name, value] : defines_)
      if (text.compare(i + 1, name.size(), name) == 0 && (!best || name.size() > best->size())) best = &name;
    if (!best || best->empty()) {
      std::string name;
      for (std::size_t k = i + 1;
           k < text.size() && (std::isalnum(static_cast<unsigned char>(text[k])) || text[k] == '_'); ++k)
        name += text[k];
      found_.error(
          at, fmt::format("undefined parameter ${}; give it with -D {}=VALUE or <default name=\"{}\" value=\"...\"/>",
                          name, name, name));
      return result + text.substr(i + 1);
    }
    result += defines_[*best];
    used_defines_.insert(*best);
    i += 1 + best->size();
  }
  return result;
}

/// Gives every reference its object.
void TreeReader::link() {
  for (const auto& [as, target] : aliases_) {
    const auto object = ids_.find(target.first);
    if (object != ids_.end())
      remember(as, object->second.first, target.second);
    else
      found_.error(target.second, "alias of an unknown id \"" + target.first + "\"");
  }
  std::vector<std::string> known;
  for (const auto& [id, object] : ids_) known.push_back(id);
  for (Object& object : tree_.objects)
    for (Child& child : object.children) {
      if (child.object) continue;
      const auto found = ids_.find(child.ref);
      if (found != ids_.end())
        child.object = found->second.first;
      else
        found_.error(child.at,
                     fmt::format("reference to an unknown id \"{}\"{}", child.ref, suggestion(child.ref, known)));
    }
  std::set<const Object*> open, done;
  cut_cycles(tree_.objects.front(), open, done);
  for (Object& object : tree_.objects) cut_cycles(object, open, done);
}

/// Takes out references through which an object would hold itself.
void TreeReader::cut_cycles(Object& object, std::set<const Object*>& open, std::set<const Object*>& done) {
  if (done.contains(&object)) return;
  open.insert(&object);
  for (Child& child : object.children) {
    if (!child.object) continue;
    if (open.contains(child.object)) {
      found_.error(child.at, fmt::format("{} \"{}\" holds itself", child.object->tag, child.ref));
      child.object = nullptr;
    } else if (open.size() > kMaxDepth) {
      found_.error(child.at, fmt::format("objects nest deeper than {} levels", kMaxDepth));
      child.object = nullptr;
    } else {
      cut_cycles(*child.object, open, done);
    }
  }
  open.erase(&object);
  done.insert(&object);
}

void TreeReader::report_unused_defines() {
  std::vector<std::string> names;
  for (const auto& [name, value] : defines_)
    if (!options_.defines.contains(name)) names.push_back(name);
  for (const auto& [name, value] : options_.defines)
    if (!used_defines_.contains(name))
      found_.warning(tree_.scene().at,
                     fmt::format("-D {}={}: the scene has no ${}{}", name, value, name, suggestion(name, names)));
}

}  // namespace

}  // namespace myrialux::mitsuba
