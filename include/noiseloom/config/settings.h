// The language in which a kind of file (a run's config, a scene, a bank) says what it may hold.
//
// A kind of file is a table of settings. A row gives the key, what is accepted, a sentence for the reader, and where
// the value lives in the struct that the file fills. The reader, its messages and suggestions, --set, the stored text
// and the help (settings_file.h) all come from that table, so that a setting is described once.
//
// Keys are patterns: "filter.groups[].sigma" stands for the key of any element of the list `groups`. The values of such
// a row live in the element (GroupSpec), those of all others in the whole (RunConfig):
//
//   {.key = "filter.groups[].sigma", .type = Type::number, .sentence = "Standard deviation of the filter.",
//    .field = [](GroupSpec& group) -> Field { return &group.kernel.sigma; }, .range = at_least(0.001)}
//
// Defaults are those of the structs themselves. A key may have several rows, each with a condition of its own.
#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <typeinfo>
#include <utility>
#include <variant>
#include <vector>

#include "noiseloom/config/tree.h"
#include "noiseloom/core/error.h"

namespace noiseloom::settings {

// What a value is. `table` is a table with rows of its own below its key; `tables` a list of them (rows below "key[]");
// `custom` has a reader and a writer of its own.
enum class Type { boolean, integer, number, duration, word, text, file, table, tables, custom };

struct Range {
  double least = -std::numeric_limits<double>::infinity();
  double most = std::numeric_limits<double>::infinity();
  bool above = false;  // greater than `least`, not equal to it

  bool contains(double value) const { return (above ? value > least : value >= least) && value <= most; }
  std::string to_string() const;  // "at least 1", "greater than 0 and at most 1"; empty if unbounded
};

constexpr Range at_least(double least, double most = std::numeric_limits<double>::infinity()) {
  return {.least = least, .most = most};
}
constexpr Range above(double least, double most = std::numeric_limits<double>::infinity()) {
  return {.least = least, .most = most, .above = true};
}

// A value that a key of type word accepts. `aliases`, separated by spaces, are what people call it elsewhere: they are
// not accepted, but lead to the right suggestion.
struct Word {
  std::string_view word;
  std::string_view meaning;
  std::string_view aliases = {};
};

// The structs that hold the values of a key, from the whole file to the innermost list element.
class Owners {
 public:
  template <class T>
  Owners with(T& owner) const {
    return with(&owner, typeid(T));
  }
  // The innermost struct of that type. Requires that there is one.
  template <class T>
  T& get() const {
    return *static_cast<T*>(find(typeid(T)));
  }

  Owners with(void* address, const std::type_info& type) const;

 private:
  void* find(const std::type_info& type) const;

  std::vector<std::pair<void*, const std::type_info*>> owners_;
};

// A field of an enumeration. Its values are numbered from 0 as the words of its setting are listed.
class Choice {
 public:
  template <class Enum>
  requires std::is_enum_v<Enum> Choice(
      Enum* value)  // NOLINT: a row returns the address of its field, whatever its type
      : value_(value),
        get_([](const void* v) { return static_cast<std::size_t>(*static_cast<const Enum*>(v)); }),
        set_([](void* v, std::size_t index) { *static_cast<Enum*>(v) = static_cast<Enum>(index); }) {}

  std::size_t index() const { return get_(value_); }
  void set(std::size_t index) const { set_(value_, index); }

 private:
  void* value_;
  std::size_t (*get_)(const void*);
  void (*set_)(void*, std::size_t);
};

// The elements of a list of tables.
class Elements {
 public:
  template <class T>
  requires std::is_class_v<T> Elements(std::vector<T>* list)  // NOLINT: as above
      : list_(list),
        size_([](const void* v) { return static_cast<const std::vector<T>*>(v)->size(); }),
        clear_([](void* v) { static_cast<std::vector<T>*>(v)->clear(); }),
        append_([](void* v) { static_cast<std::vector<T>*>(v)->emplace_back(); }),
        with_([](void* v, std::size_t i, const Owners& owners) {
          return owners.with((*static_cast<std::vector<T>*>(v))[i]);
        }) {}

  std::size_t size() const { return size_(list_); }
  void clear() const { clear_(list_); }
  void append() const { append_(list_); }  // an element of default values
  // `owners`, and the i-th element. Valid until the list changes.
  Owners with(std::size_t i, const Owners& owners) const { return with_(list_, i, owners); }

 private:
  void* list_;
  std::size_t (*size_)(const void*);
  void (*clear_)(void*);
  void (*append_)(void*);
  Owners (*with_)(void*, std::size_t, const Owners&);
};

// Where a value lives. A vector holds the values of a row that is a list. A bool of a row of type table is true where
// the table is present.
using Field = std::variant<bool*, int*, std::int64_t*, std::uint64_t*, double*, std::string*, std::vector<int>*,
                           std::vector<double>*, std::vector<std::string>*, Choice, Elements>;

// From the struct that holds a value to its field: made of a lambda without captures, [](Owner&) -> Field.
class Access {
 public:
  constexpr Access() = default;
  template <class Lambda>
  requires std::is_empty_v<Lambda> && std::default_initializable<Lambda>
  constexpr Access(Lambda)  // NOLINT: a row is written with the lambda itself
      : field_([](const Owners& owners) { return field_of(owners, &Lambda::operator()); }) {}

  explicit operator bool() const { return field_ != nullptr; }
  Field operator()(const Owners& owners) const { return field_(owners); }

 private:
  template <class Lambda, class Owner>
  static Field field_of(const Owners& owners, Field (Lambda::*)(Owner&) const) {
    return Lambda{}(owners.get<Owner>());
  }

  Field (*field_)(const Owners&) = nullptr;
};

// The setting applies only where another setting, of type word, has one of these words. That setting has one row; where
// it belongs to a list element its row stands before.
struct Condition {
  std::string_view key = {};
  std::string_view words = {};  // separated by single blanks

  bool accepts(std::string_view word) const;
  std::string_view first_word() const { return words.substr(0, words.find(' ')); }
  // `"anneal", "fast" or "auto"`
  std::string to_string() const;
};

class Reader;
class Writer;
struct Setting;

// A value that was found in a file, with its row and the key as the user wrote it ("filter.groups[1].size").
struct Found {
  const Setting& setting;
  const Value& value;
  const std::string& shown;
  const Owners& owners;
};

// A type of one kind of file alone.
struct CustomType {
  std::string (*accepted)(const Setting&);
  void (*read)(Reader&, const Found&);
  // TOML on one line; empty if there is nothing to say.
  std::string (*text)(const Writer&, const Setting&, const Owners&);
  std::string_view help = {};  // in place of `accepted` in the help, where the words are listed below it
  // The key of a table that a text stands for when it is written in place of the table: with --set further keys can be
  // put beside it.
  std::string_view shorthand = {};
};

struct Setting {
  std::string_view key;
  Type type = Type::number;
  std::string_view sentence;
  Access field = {};  // a table and a custom type may do without
  bool list = false;  // a list of values of that type; not for table, tables and custom
  Range range = {};   // integer, number, duration
  std::string_view unit = {};
  std::span<const Word> words = {};
  Condition when = {};
  bool required = false;
  // file: its reader also takes folders, patterns of names and datasets of a file, and so says itself what is missing.
  bool is_found_by_reader = false;
  bool zero_is_unset = false;      // zero (or no text, or the first word) means that the file does not say
  bool negative_is_unset = false;  // a number below zero, which no file may hold, means that the file does not say
  bool one_of = false;             // table: holds exactly one of its keys; that of a --set replaces that of the file
  std::string_view example = {};   // tables: `a list of tables such as <example>`
  const CustomType* custom = nullptr;
  // What older files call the leaf of the key: read as if they had the key itself. Not within lists.
  std::string_view former = {};
  // word: called when the word has been set, for defaults that depend on it.
  void (*chosen)(const Owners&) = nullptr;
  // table, tables: called when all below has been read, sound or not.
  void (*check)(Reader&, const Found&) = nullptr;

  std::string_view leaf() const { return key.substr(key.rfind('.') + 1); }
  // Key of the table that the row lies in; "" for the whole file.
  std::string_view parent() const;
  // "an integer, at least 1": what the value must be.
  std::string accepted() const;
  // The same without regard to `list`: what each element must be.
  std::string accepted_element() const;
};

// One kind of file: what it is called, and the settings that it may hold.
struct FileKind {
  std::string_view noun;  // "config", "scene": `a scene needs the table [image]`
  // In the order of the stored text; a key with a dot comes after its table.
  std::span<const Setting> settings;
  // Called at the end: what settings ask of each other. The owners hold what could be read.
  void (*check)(Reader&, const Value& root, const Owners&) = nullptr;
  std::string_view override_example = {};            // "texture.seed=2"
  std::shared_ptr<void> (*make)(Owners&) = nullptr;  // a struct of default values, added to the owners

  // Rows directly below the table `parent` ("" for the whole file).
  std::vector<const Setting*> below(std::string_view parent) const;
  // The first row of that key. Requires that there is one.
  const Setting& row(std::string_view key) const;
  bool has_row(std::string_view key) const;
  bool applies(const Setting& setting, const Owners& owners) const;
  // The leaf that `leaf` of the table `parent` is called now: itself, unless it is a former one.
  std::string_view current_leaf(std::string_view parent, std::string_view leaf) const;
};

// The kind, with `make` for the struct that it fills.
template <class T>
FileKind file_kind(FileKind kind) {
  kind.make = [](Owners& owners) {
    const auto made = std::make_shared<T>();
    owners = owners.with(*made);
    return std::shared_ptr<void>(made);
  };
  return kind;
}

// The word that a field of type word holds; "" if it is none of the setting's.
std::string_view current_word(const Setting& setting, const Owners& owners);
// False, and nothing set, if `text` is none of the setting's words.
bool set_word(const Setting& setting, std::string_view text, const Owners& owners);

// The accepted word that `found` is a misspelling or another name of, or "".
std::string suggestion(std::string_view found, std::span<const Word> words);
// `unknown kernel; did you mean "ema"? accepted: box, gauss, ...`
std::string unknown_word(std::string_view found, const Setting& setting);
// "box, gauss, binomial"
std::string list_of(std::span<const Word> words);

}  // namespace noiseloom::settings
