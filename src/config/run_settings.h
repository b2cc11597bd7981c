// The config of a run as a kind of file (settings.h): its table of settings, and what no row can say by itself.
#pragma once

#include <vector>

#include "noiseloom/config/config.h"
#include "noiseloom/config/settings.h"
#include "noiseloom/config/settings_reader.h"
#include "noiseloom/problem/spec.h"

namespace noiseloom::settings {

const FileKind& run_config_kind();

// Types of a run's config (run_settings_types.cpp).
extern const CustomType size_type;       // texture.size: the axes by name, in the order written
extern const CustomType axes_type;       // names of axes of texture.size, into a vector<int> of their numbers
extern const CustomType some_axes_type;  // the same; none is not written

// texture.samples (run_settings_samples.cpp): a word, or a table that holds it and what goes with it.
extern const CustomType samples_type;
// The built-in sample spaces, and "file".
std::span<const Word> sample_words();
// The rows, and behind texture.size those of texture.samples: one for each parameter of a space among them.
std::vector<Setting> with_rows_of_samples(std::vector<Setting> rows);
// And before those of [energy] those of [filter] (run_settings_filter.cpp).
std::vector<Setting> with_rows_of_filter(std::vector<Setting> rows);
// Bounds that no texture needs to pass, and within which all arithmetic on taps stays finite.
inline constexpr double largest_reach = 65536;
inline constexpr double least_sigma = 0.001;
// For the row of the space: its parameters are as they are where the config does not say.
void take_initial_parameters(const Owners& owners);

// Checks of the table's rows and of the whole (run_settings_checks.cpp).
void check_groups(Reader& reader, const Found& groups);
void check_temperatures(Reader& reader, const Found& temperatures);
void check_method(Reader& reader, const Value& root, const Owners& owners);
// Nets need sizes that are powers of two.
void check_sizes_of_nets(Reader& reader, const Value& root, const RunConfig& config);

// The defaults of one kernel (gauss-energy has a wider sigma than gauss).
KernelSpec default_kernel(KernelKind kind);
// The names that texture.size gives to the axes, also where its sizes are in fault; empty if it has none.
std::vector<std::string> axis_names(const Value& root);

}  // namespace noiseloom::settings
