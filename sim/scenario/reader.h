#pragma once

#include <map>
#include <string>
#include <vector>

#include "sim/base/error.h"
#include "sim/scenario/key_visitor.h"
#include "sim/scenario/yaml_tree.h"

namespace reamsim {

/// Where each key of a scenario stands, by path ("motion.keyframes.0.time_s"); a key that is absent stands where its
/// section does.
class KeyLocations {
 public:
  void set(const std::string& path, const SourceLocation& where, bool given);
  [[nodiscard]] SourceLocation of(const std::string& path) const;
  /// Whether the file (or --set) has the key.
  [[nodiscard]] bool given(const std::string& path) const;

 private:
  struct Place {
    SourceLocation where;
    bool given = false;
  };
  std::map<std::string, Place> places_;
};

/// Reads the values of a document whose keys are all known. Each key is checked by itself (type, range, choice, where
/// it applies); rules between keys are check_rules()'s. Paths are expanded and made absolute.
class ScenarioReader : public KeyVisitor {
 public:
  /// `folder` is what relative paths are relative to; `file` stands in messages.
  ScenarioReader(YamlNodePtr document, std::string file, std::string folder);

  [[nodiscard]] const KeyLocations& locations() const { return locations_; }

  void number(const KeyInfo& info, double& value) override;
  void integer(const KeyInfo& info, int& value) override;
  void flag(const KeyInfo& info, bool& value) override;
  void text(const KeyInfo& info, std::string& value) override;
  void choices(const KeyInfo& info, std::vector<std::string>& values) override;
  void names(const KeyInfo& info, std::vector<std::string>& values) override;
  void vector(const KeyInfo& info, Vec3& value) override;
  void optional_vector(const KeyInfo& info, std::optional<Vec3>& value) override;
  void points(const KeyInfo& info, std::vector<Vec3>& values) override;
  void optional_quaternion(const KeyInfo& info, std::optional<Quat>& value) override;
  void group(const KeyGroup& group) override;
  void defaults(const std::function<void()>& change) override { change(); }

 protected:
  bool begin_section(const KeyInfo& info) override;
  bool begin_optional_section(const KeyInfo& info, bool has_value) override;
  void end_section() override;
  std::size_t begin_list(const KeyInfo& info, std::size_t size) override;
  void begin_item(std::size_t index) override;
  void end_list() override;

 private:
  /// A section, list or item that is being read; its node is null where the document does not have it.
  struct Level {
    YamlNodePtr node;
    std::string path;
    SourceLocation where;
    std::map<std::string_view, std::string> chosen;  // values of the choices read so far
  };

  /// The value of a key, or nullptr where it is absent. Throws where it is needed, or may not stand here.
  YamlNodePtr take(const KeyInfo& info);
  [[nodiscard]] bool applies(const KeyInfo& info, std::string& why_not) const;
  void push(const KeyInfo& info, YamlNodePtr node);
  [[nodiscard]] std::string path_of(std::string_view name) const;
  [[nodiscard]] std::vector<double> components(const KeyInfo& info, const YamlNode& node, std::size_t count,
                                               const std::string& expected) const;
  [[nodiscard]] double checked_number(const KeyInfo& info, const YamlNode& node, const std::string& expected) const;
  [[nodiscard]] std::string checked_text(const KeyInfo& info, const YamlNode& node) const;
  [[noreturn]] void reject(std::string_view key, const YamlNode& node, const std::string& found,
                           const std::string& expected) const;

  std::string file_;
  std::string folder_;
  std::vector<Level> levels_;
  KeyLocations locations_;
};

}  // namespace reamsim
