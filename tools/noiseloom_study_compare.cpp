// compare: textures side by side, under the same filters.
#include <fmt/format.h>

#include <filesystem>
#include <map>
#include <memory>
#include <string>

#include "noiseloom/core/parallel.h"
#include "noiseloom/measure/compare.h"
#include "noiseloom_options.h"
#include "noiseloom_study.h"

namespace noiseloom {
namespace {

struct CompareArguments {
  TextureArguments texture;
  std::string table = "markdown";
  ResultOptions result;
};

// "fast=a.h5,b.h5": a column called fast, of several seeds; "a.h5": a column of one, called by its file.
CompareColumn column_of(const CompareArguments& arguments, const std::string& word) {
  CompareColumn column;
  const std::size_t equals = word.find('=');
  const bool is_named = equals != std::string::npos && !std::filesystem::exists(word);
  const std::string files = is_named ? word.substr(equals + 1) : word;
  column.name = is_named ? word.substr(0, equals) : std::filesystem::path(word).stem().string();
  const auto is_missing = [&](const std::string& name) {
    if (name.empty()) throw UserError("command line", word + ": must be NAME=FILE,FILE... with no name left out");
  };
  is_missing(column.name);
  for (std::size_t at = 0; at <= files.size();) {
    const std::size_t end = is_named ? std::min(files.find(',', at), files.size()) : files.size();
    column.files.push_back(files.substr(at, end - at));
    at = end + 1;
  }
  for (const std::string& file : column.files) {
    is_missing(file);
    column.textures.push_back(load_argument(arguments.texture, file));
    if (!column.textures.back().config)
      throw UserError(file,
                      "not a run file: say what the values mean by --set texture.samples=uniform, or by --config");
  }
  return column;
}

// Columns of one name are called by their whole paths.
void name_apart(std::vector<CompareColumn>& columns) {
  std::map<std::string, int> count;
  for (const CompareColumn& column : columns) ++count[column.name];
  for (CompareColumn& column : columns) {
    if (count[column.name] > 1) column.name = column.files.front();
  }
}

void run_compare(const CompareArguments& arguments) {
  if (arguments.texture.files.size() < 2) throw UserError("command line", "compare takes two textures or more");
  ThreadPool pool(threads_of(arguments.texture));
  std::vector<CompareColumn> columns;
  for (const std::string& word : arguments.texture.files) columns.push_back(column_of(arguments, word));
  name_apart(columns);
  const Comparison comparison = compare(columns, pool);
  std::string text = comparison_table(comparison, arguments.table);
  for (std::size_t t = 1; t < comparison.textures.size() && arguments.table == "markdown"; ++t)
    text += fmt::format("\n{} beside {}: {}\n", comparison.textures[t].name, comparison.textures.front().name,
                        comparison.permutations[t - 1]);
  print_result(arguments.result, text, comparison_json(comparison) + "\n");
}

}  // namespace

void add_compare(CLI::App& app) {
  const auto arguments = std::make_shared<CompareArguments>();
  auto* const command = app.add_subcommand("compare", "Textures side by side, under the same filters");
  add_texture_arguments(*command, arguments->texture);
  command->add_option("--table", arguments->table, "markdown (default), latex or csv")
      ->check(CLI::IsMember({"markdown", "latex", "csv"}));
  add_result_options(*command, arguments->result, ShowsProgress::no);
  command->footer(
      "R of each texture under the filter of the first (or of --config) and the usual ones, the power below 0.05 "
      "cycles a\n"
      "pixel, and whether slices hold the samples of the first one's in another order. NAME=A.h5,B.h5,C.h5 is one "
      "column\n"
      "of several seeds: means, with their standard errors.\n\n"
      "  noiseloom compare mine.h5 theirs_{}.png --config mine.toml\n"
      "  noiseloom compare fast=f1.h5,f2.h5,f3.h5 stbn=s1.h5,s2.h5,s3.h5 --table latex\n");
  command->callback([arguments] { run_compare(*arguments); });
}

}  // namespace noiseloom
