#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <set>

#include "noiseloom/accuracy/accuracy_table.h"
#include "noiseloom/core/error.h"
#include "noiseloom/image/encoding.h"

namespace noiseloom {
namespace {

constexpr const char* column_names[] = {"method",   "setting", "value",  "iterations", "seed",   "runs",
                                        "threads",  "seconds", "R",      "R_least",    "R_most", "R_8_bit",
                                        "R_16_bit", "default", "pareto", "command"};
constexpr std::size_t num_columns = std::size(column_names);

std::string quoted(const std::string& field) {
  if (field.find_first_of(",\"\r\n") == std::string::npos) return field;
  std::string text = "\"";
  for (const char c : field) {
    if (c == '"') text += '"';
    text += c;
  }
  text += '"';
  return text;
}

std::string joined(const std::vector<std::string>& fields) {
  std::string line;
  for (std::size_t i = 0; i < fields.size(); ++i) {
    if (i > 0) line += ',';
    line += quoted(fields[i]);
  }
  line += '\n';
  return line;
}

std::string optional_number(const std::optional<double>& value) { return value ? shortest_number(*value) : ""; }

struct Record {
  int line = 1;  // on which it begins
  std::vector<std::string> fields;
  bool whole = true;  // ends in a line end, with all quotes closed
};

// One record from `at` on.
Record next_record(const std::string& text, std::size_t& at, int& line) {
  Record record{line, {""}, false};
  bool in_quotes = false;
  for (; at < text.size(); ++at) {
    const char c = text[at];
    if (c == '\n') ++line;
    if (in_quotes) {
      if (c == '"' && at + 1 < text.size() && text[at + 1] == '"') {
        record.fields.back() += text[++at];
      } else if (c == '"') {
        in_quotes = false;
      } else {
        record.fields.back() += c;
      }
    } else if (c == '"') {
      in_quotes = true;
    } else if (c == ',') {
      record.fields.emplace_back();
    } else if (c == '\n') {
      record.whole = true;
      ++at;
      break;
    } else if (c != '\r') {
      record.fields.back() += c;
    }
  }
  return record;
}

// The fields of one line as values; the first that is wrong is told.
class RowReader {
 public:
  RowReader(const Record& record, const std::string& name)
      : record_(record), where_(fmt::format("{}:{}", name, record.line)) {}

  std::optional<AccuracyRow> row(std::vector<Fault>& faults) {
    AccuracyRow row;
    if (!record_.whole || record_.fields.size() != num_columns) {
      faults.push_back({where_, fmt::format("{} of {} columns{}: the line is cut or damaged", record_.fields.size(),
                                            num_columns, record_.whole ? "" : " and no line end")});
      return std::nullopt;
    }
    const std::optional<Method> method = method_of_name(record_.fields[0]);
    if (!method) fail(0, "a method");
    row.point.method = method.value_or(Method::anneal);
    row.point.setting = record_.fields[1];
    row.point.value = record_.fields[2];
    row.iterations = row.point.iterations = number<std::int64_t>(3, has_iterations(row.point.method) ? 1 : 0);
    row.seed = number<std::uint64_t>(4, 0);
    row.runs = number<int>(5, 1);
    row.threads = number<int>(6, 1);
    row.seconds = number<double>(7, 0);
    row.relative_error = number<double>(8, 0);
    row.least_error = number<double>(9, 0);
    row.largest_error = number<double>(10, 0);
    if (!record_.fields[11].empty()) row.r_8bit = number<double>(11, 0);
    if (!record_.fields[12].empty()) row.r_16bit = number<double>(12, 0);
    row.point.is_default = yes_no(13, "yes", "no");
    yes_no(14, "yes", "no");
    row.command = record_.fields[15];
    if (fault_.empty()) return row;
    faults.push_back({where_, fault_});
    return std::nullopt;
  }

 private:
  void fail(std::size_t column, const std::string& wanted) {
    if (fault_.empty())
      fault_ = fmt::format("{} = \"{}\": must be {}", column_names[column], record_.fields[column], wanted);
  }
  bool yes_no(std::size_t column, const std::string& yes, const std::string& no) {
    const std::string& field = record_.fields[column];
    if (field != yes && field != no) fail(column, yes + " or " + no);
    return field == yes;
  }
  template <class T>
  T number(std::size_t column, T least) {
    const std::string& field = record_.fields[column];
    T value{};
    const auto [end, error] = std::from_chars(field.data(), field.data() + field.size(), value);
    const bool good = error == std::errc{} && end == field.data() + field.size() &&
                      std::isfinite(static_cast<double>(value)) && value >= least;
    if (!good) fail(column, fmt::format("a number, at least {}", least));
    return value;
  }

  const Record& record_;
  std::string where_;
  std::string fault_;
};

}  // namespace

std::string accuracy_csv(const std::vector<AccuracyRow>& rows) {
  std::string text = joined({std::begin(column_names), std::end(column_names)});
  const std::vector<bool> front = pareto_front(rows);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const AccuracyRow& row = rows[i];
    text += joined({method_name(row.point.method), row.point.setting, row.point.value, std::to_string(row.iterations),
                    std::to_string(row.seed), std::to_string(row.runs), std::to_string(row.threads),
                    shortest_number(row.seconds), shortest_number(row.relative_error), shortest_number(row.least_error),
                    shortest_number(row.largest_error), optional_number(row.r_8bit), optional_number(row.r_16bit),
                    row.point.is_default ? "yes" : "no", front[i] ? "yes" : "no", row.command});
  }
  return text;
}

std::vector<AccuracyRow> parse_accuracy_csv(const std::string& text, const std::string& name) {
  std::size_t at = 0;
  int line = 1;
  const Record header = next_record(text, at, line);
  if (!header.whole || header.fields != std::vector<std::string>(std::begin(column_names), std::end(column_names)))
    throw UserError(name + ":1", "does not begin with the columns of accuracy.csv (" + std::string(column_names[0]) +
                                     ", " + column_names[1] + ", ...)");
  std::vector<AccuracyRow> rows;
  std::vector<Fault> faults;
  std::set<std::string> names;
  while (at < text.size()) {
    const Record record = next_record(text, at, line);
    const auto row = RowReader(record, name).row(faults);
    if (!row) continue;
    if (!names.insert(point_name(row->point)).second)
      faults.push_back({fmt::format("{}:{}", name, record.line), "the same point stands on an earlier line"});
    rows.push_back(*row);
  }
  throw_if_any(std::move(faults));
  return rows;
}

}  // namespace noiseloom
