// The results of `accuracy`: rows, their table on disk (accuracy.csv) and what they say in sentences.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "noiseloom/accuracy/accuracy_ladder.h"

namespace noiseloom {

// What one run of a point came to.
struct AccuracyRun {
  double seconds = 0;            // of the whole process
  double relative_error = 0;     // R of the samples as they are
  std::optional<double> r_8bit;  // R once they are stored in so many bits; none where the samples have no bounds
  std::optional<double> r_16bit;
};

// A point: means over its runs, each with a seed of its own, and how far R spreads.
struct AccuracyRow {
  AccuracyPoint point;
  std::int64_t iterations = 0;  // done; those of the point where it names them
  std::uint64_t seed = 0;       // of the first run; every further one has the next
  int runs = 0;
  int threads = 0;
  double seconds = 0;
  double relative_error = 0;
  double least_error = 0;  // of all runs
  double largest_error = 0;
  std::optional<double> r_8bit;
  std::optional<double> r_16bit;
  std::string command;  // of the first run

  void add(const AccuracyRun& run);
};

// The rows as points that take `runs` runs each.
std::vector<TimedPoint> timed(const std::vector<AccuracyRow>& rows, int runs = 1);

// True for the rows that no other row beats: none has as small a mean of R in less time, or a smaller one in as little.
std::vector<bool> pareto_front(const std::vector<AccuracyRow>& rows);

// Comma-separated, first line the names, text quoted where needed (RFC 4180), numbers with the digits that read back to
// the same double. Columns: method, setting, value, iterations, seed, runs, threads, seconds, R, R_least, R_most,
// R_8_bit, R_16_bit, default, pareto, command.
std::string accuracy_csv(const std::vector<AccuracyRow>& rows);
// Reads it back (pareto is not read: it follows from the rest). Throws UserError naming the lines that are damaged.
std::vector<AccuracyRow> parse_accuracy_csv(const std::string& text, const std::string& name);

// What the rows say, each a sentence with its numbers: what the last per cents of error cost, the default against the
// best, the default against the front, the methods against each other, output bits. Requires a row.
std::vector<std::string> accuracy_sentences(const std::vector<AccuracyRow>& rows);

// The row of the default and that of the least R (of the shortest among equals); nullptr where there is none.
const AccuracyRow* default_row(const std::vector<AccuracyRow>& rows);
const AccuracyRow* best_row(const std::vector<AccuracyRow>& rows);
// The run that a knob's row is compared with: the same method and iterations with nothing else changed.
const AccuracyRow* base_row(const std::vector<AccuracyRow>& rows, const AccuracyRow& knob);

// "0.1234", and of several runs "0.1234 (0.1230 to 0.1239)".
std::string error_with_spread(const AccuracyRow& row);

// The point with the iterations that were done, for people.
std::string describe_row(const AccuracyRow& row);
// "4.3 % more", "12 % less", "the same", for a ratio to 1.
std::string difference_text(double ratio);

}  // namespace noiseloom
