// rewrite_run_file IN OUT CHANGE...: a run file with other contents and digests that are right, for tests of what the
// programs do with files that something else has written.
//
//   state.step=1000            an attribute of /state, in the type that it has
//   provenance.parts=7         likewise of /provenance
//   state.finished:text=x      the same as text, :number= as a double
//   state.inputs:digest=A,B    the XXH64 of the bytes of files
//   history.sweep[1]=5         a value of a column
//   /state/permutation[2][7]=9 element 7 of slice 2 of a dataset
//   /samples:type=uint32       the same bytes as another type
//   inputs.KEY[3]=0.5          an element of an input; inputs.KEY:shape=4,2 its shape
//   config:OLD=>NEW            OLD in the text of the config becomes NEW
//   extents=4,4,2              slices are cut or filled up with zeros
//   -state.step, -history.sweep, -/pdf, -inputs.KEY    without it
#include <algorithm>
#include <cstring>
#include <fstream>
#include <iostream>
#include <map>
#include <span>
#include <sstream>

#include "noiseloom/files/digest.h"
#include "noiseloom/files/file_ops.h"
#include "noiseloom/files/run_file.h"

namespace noiseloom {
namespace {

using Blocks = std::vector<std::vector<std::vector<std::byte>>>;  // dataset, slice, bytes

[[noreturn]] void refuse(const std::string& change) { throw std::runtime_error("cannot carry out " + change); }

// "sweep[1]" is taken apart into the name and the numbers in brackets.
struct Place {
  explicit Place(const std::string& text) : name(text.substr(0, text.find('['))) {
    // Keys of inputs have brackets themselves: only those at the end are indices of elements.
    if (text.starts_with("filter.") || text.starts_with("texture.")) name = text.substr(0, text.rfind('['));
    for (std::size_t at = text.find('[', name.size()); at != std::string::npos; at = text.find('[', at + 1)) {
      indices.push_back(std::stoul(text.substr(at + 1)));
    }
  }
  std::string name;
  std::vector<std::size_t> indices;
};

template <class T>
void put(std::byte* bytes, std::size_t index, T value) {
  std::memcpy(bytes + index * sizeof(T), &value, sizeof(T));
}

std::string digest_of_files(const std::string& names) {
  Digest digest;
  std::istringstream list(names);
  for (std::string name; std::getline(list, name, ',');) {
    std::ifstream file(name, std::ios::binary);
    const std::string bytes{std::istreambuf_iterator<char>(file), {}};
    digest.update(std::as_bytes(std::span(bytes)));
  }
  return to_hex(digest.value());
}

class Rewriter {
 public:
  explicit Rewriter(const std::string& path) {
    const RunFileReader reader(path);
    content_ = reader.content();
    for (int d = 0; d < static_cast<int>(content_.datasets.size()); ++d) {
      blocks_.emplace_back();
      for (const SliceIndex slice : content_.extents.slices()) {
        const SliceDataset& dataset = content_.datasets[static_cast<std::size_t>(d)];
        blocks_.back().emplace_back(bytes_per_slice(dataset, content_.extents));
        reader.read_slice(d, slice, blocks_.back().back());
      }
    }
  }

  void apply(const std::string& change) {
    if (change.starts_with('-')) return erase(change.substr(1));
    if (change.starts_with("config:")) return set_config(change.substr(7));
    const std::size_t equals = change.find('=');
    const std::string key = change.substr(0, equals);
    const std::string value = change.substr(equals + 1);
    if (key.starts_with("state.")) return set_attribute(content_.state, key.substr(6), value);
    if (key.starts_with("provenance.")) return set_attribute(content_.provenance, key.substr(11), value);
    if (key.starts_with("history.")) return set_history(Place(key.substr(8)), std::stod(value));
    if (key.starts_with("inputs.")) return set_input(key.substr(7), value);
    if (key == "extents") return set_extents(value);
    set_element(key, value);
  }

  void write(const std::string& path) const {
    RunFileWriter writer(posix_file_ops(), path, content_);
    for (std::size_t d = 0; d < content_.datasets.size(); ++d) {
      for (const SliceIndex slice : content_.extents.slices()) {
        std::vector<std::byte> bytes;
        if (static_cast<std::size_t>(slice) < blocks_[d].size()) bytes = blocks_[d][static_cast<std::size_t>(slice)];
        bytes.resize(bytes_per_slice(content_.datasets[d], content_.extents));
        writer.write_slice(static_cast<int>(d), slice, bytes);
      }
    }
    writer.publish();
  }

 private:
  std::size_t dataset(const std::string& name) const {
    const auto found = std::find_if(content_.datasets.begin(), content_.datasets.end(),
                                    [&](const SliceDataset& dataset) { return dataset.name == name; });
    if (found == content_.datasets.end()) refuse(name);
    return static_cast<std::size_t>(found - content_.datasets.begin());
  }

  void erase(const std::string& what) {
    if (what.starts_with("state.")) {
      content_.state.erase(what.substr(6));
    } else if (what.starts_with("history.")) {
      std::erase_if(content_.history, [&](const auto& column) { return column.first == what.substr(8); });
    } else if (what.starts_with("inputs.")) {
      std::erase_if(content_.inputs, [&](const RunFileInput& input) { return input.key == what.substr(7); });
    } else {
      const auto at = static_cast<std::ptrdiff_t>(dataset(what));
      content_.datasets.erase(content_.datasets.begin() + at);
      blocks_.erase(blocks_.begin() + at);
    }
  }

  static void set_attribute(std::map<std::string, Attribute>& attributes, const std::string& key,
                            const std::string& value) {
    const std::string name = key.substr(0, key.find(':'));
    Attribute& attribute = attributes[name];
    if (key.ends_with(":text")) attribute = std::string();
    if (key.ends_with(":number")) attribute = 0.0;
    if (key.ends_with(":digest")) {
      attribute = digest_of_files(value);
      return;
    }
    if (std::holds_alternative<std::int64_t>(attribute)) {
      attribute = std::int64_t{std::stoll(value)};
    } else if (std::holds_alternative<double>(attribute)) {
      attribute = std::stod(value);
    } else {
      attribute = value;
    }
  }

  void set_history(const Place& place, double value) {
    for (auto& [name, values] : content_.history) {
      if (name == place.name) values.at(place.indices.at(0)) = value;
    }
  }

  void set_input(const std::string& key, const std::string& value) {
    const bool shape = key.ends_with(":shape");
    const Place place(shape ? key.substr(0, key.size() - 6) + "[0]" : key);
    for (RunFileInput& input : content_.inputs) {
      if (input.key != place.name) continue;
      InputArray array = *input.array;
      if (shape) {
        array.shape = numbers(value);
      } else {
        std::visit(
            [&](auto& values) {
              std::vector changed(values.begin(), values.end());
              changed.at(place.indices.at(0)) = static_cast<typename decltype(changed)::value_type>(std::stod(value));
              values = std::move(changed);
            },
            array.values);
      }
      input.array = std::make_shared<const InputArray>(std::move(array));
      return;
    }
    refuse(key);
  }

  void set_config(const std::string& change) {
    const std::string before = change.substr(0, change.find("=>"));
    const std::string after = change.substr(before.size() + 2);
    const std::size_t at = content_.config.find(before);
    if (at == std::string::npos) refuse(before);
    content_.config.replace(at, before.size(), after);
  }

  void set_extents(const std::string& text) {
    const std::vector<std::int64_t> sizes = numbers(text);
    std::vector<std::string> names;
    for (int axis = 0; axis < static_cast<int>(sizes.size()); ++axis) names.push_back(content_.extents.name(axis));
    content_.extents = Extents(sizes, names);
  }

  void set_element(const std::string& key, const std::string& value) {
    if (key.ends_with(":type")) {
      SliceDataset& spec = content_.datasets[dataset(key.substr(0, key.size() - 5))];
      spec.type = value == "uint32"   ? ElementType::uint32
                  : value == "uint64" ? ElementType::uint64
                                      : ElementType::float32;
      return;
    }
    const Place place(key);
    const std::size_t d = dataset(place.name);
    std::byte* const bytes = blocks_[d].at(place.indices.at(0)).data();
    switch (content_.datasets[d].type) {
      case ElementType::float32:
        return put(bytes, place.indices.at(1), std::stof(value));
      case ElementType::uint32:
        return put(bytes, place.indices.at(1), static_cast<std::uint32_t>(std::stoul(value)));
      case ElementType::uint64:
        return put(bytes, place.indices.at(1), std::uint64_t{std::stoull(value)});
    }
  }

  static std::vector<std::int64_t> numbers(const std::string& text) {
    std::vector<std::int64_t> values;
    for (std::size_t at = 0; at < text.size(); at = std::min(text.find(',', at), text.size() - 1) + 1) {
      values.push_back(std::stoll(text.substr(at)));
    }
    return values;
  }

  RunFileContent content_;
  Blocks blocks_;
};

}  // namespace
}  // namespace noiseloom

int main(int argc, char** argv) {
  try {
    noiseloom::Rewriter file(argv[1]);
    for (int i = 3; i < argc; ++i) file.apply(argv[i]);
    file.write(argv[2]);
    return 0;
  } catch (const std::exception& error) {
    std::cerr << error.what() << "\n";
    return 1;
  }
}
