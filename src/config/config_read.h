// From a tree to a RunConfig, collecting every fault on the way.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "config/config_tree.h"
#include "config/settings.h"

namespace noiseloom::settings {

class ConfigReader {
 public:
  ConfigReader(std::string folder, MissingFiles missing) : folder_(std::move(folder)), missing_(missing) {}

  // What could be read; a usable config only if there are no faults.
  RunConfig read(const Value& root);
  // Of the last read, in the order of the lines of the config, those of overrides last.
  std::vector<Fault> faults() const;

 private:
  // `pattern` is the key in the table of settings ("filter.groups[].size"), `shown` what the user wrote
  // ("filter.groups[1].size").
  void read_table(const Value& value, std::string_view pattern, const std::string& shown, const Target& target);
  void read_key(const std::vector<const Setting*>& rows, const Value& parent, const std::string& shown,
                const Target& target);
  void report_unknown_keys(const Table& table, std::string_view pattern, const std::string& shown,
                           const Target& target);
  void read_value(const Setting& setting, const Value& value, const std::string& shown, const Target& target);
  void read_scalar(const Setting& setting, const Value& value, const std::string& shown, const Target& target);
  void read_number(const Setting& setting, double number, const Value& value, const std::string& shown,
                   const Target& target);
  void read_word(const Setting& setting, const Value& value, const std::string& shown, const Target& target);
  // False, and nothing set, if the value is none of the setting's words.
  bool set_word(const Setting& setting, const Value& value, const Target& target);
  void read_file(const Setting& setting, const Value& value, const std::string& shown, const Target& target);
  void read_size(const Setting& setting, const Value& value, const std::string& shown);
  void set_extents(const Value& value, const std::string& shown, const std::vector<std::int64_t>& sizes);
  void read_samples(const Setting& setting, const Value& value, const std::string& shown, const Target& target);
  void read_groups(const Setting& setting, const Value& value, const std::string& shown);
  void read_axes(const Setting& setting, const Value& value, const std::string& shown, const Target& target);
  void read_stop(const Value& value, const std::string& shown, const Target& target);
  void check_weights(const Value& groups, const std::string& shown);
  void check_axes_are_disjoint(const Array& groups, const std::string& shown);
  void check_temperatures(const Value& value, const std::string& shown);
  // Settings of all tables depend on the method, so it is looked up before they are read.
  void look_up_method(const Value& root);
  void check_void_and_cluster(const Value& root);

  // `shown = value: text`
  void fault(const Value& value, const std::string& shown, const std::string& text);
  void fault(const Place& place, const std::string& text);
  // True unless what the condition names is itself in fault, so that nothing follows from it.
  bool decided(const Setting& setting) const;

  std::string folder_;
  MissingFiles missing_;
  RunConfig config_;
  std::vector<std::string> axis_names_;      // also where sizes are in fault
  std::vector<std::string_view> undecided_;  // keys of type word that are in fault
  std::vector<std::pair<Place, Fault>> faults_;
};

}  // namespace noiseloom::settings
