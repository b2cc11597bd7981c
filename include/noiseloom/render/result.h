// What a rendering gives: errors, pictures, and what was done for them.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "noiseloom/core/parallel.h"
#include "noiseloom/measure/spectrum.h"
#include "noiseloom/render/expectation.h"
#include "noiseloom/render/noise.h"
#include "noiseloom/render/passes.h"
#include "noiseloom/render/scene.h"

namespace noiseloom::render {

// Planar [channel][y][x].
struct ResultPicture {
  int width = 0;
  int height = 0;
  int channels = 0;
  std::vector<float> values;
};

// Where the error of one noise in one effect lies, over all frames (behind an average over time, the later half of
// them). Powers are mean squares for each frequency: those of all noises have one scale.
struct ErrorSpectrum {
  PlaneSpectrum across;             // x and y: the mean over frames
  PlaneSpectrum over_time;          // x and time: the mean over rows
  std::array<double, 3> bands{};    // mean squares below 0.05 cycles a pixel, from there to 0.15, and above
  std::array<double, 3> in_time{};  // the same in cycles a frame
  bool is_empty() const { return across.power.empty(); }
};

struct PassResult {
  PlannedPass planned;
  std::int64_t calls = 0;
  Counts counted{};
  double seconds = 0;  // of one processor
};

struct Result {
  std::vector<Effect> effects;
  std::vector<std::string> noises;
  std::optional<std::size_t> white;  // which of them is white noise: the first of that kind, whatever its name
  std::vector<Stage> stages;
  std::vector<Metric> metrics;  // rmse first
  int frames = 0;
  int repeats = 0;
  // Mean squared errors: [effect][noise][repeat][stage][frame].
  std::vector<double> squares;
  // The same of every other metric: [metric][effect]..., those of roots squared.
  std::vector<std::vector<double>> further;
  std::vector<ResultPicture> truths;    // [effect][stage] of the last frame, where pictures are put out
  std::vector<ResultPicture> pictures;  // [effect][noise][stage] of the last frame, where they are put out
  std::vector<ErrorSpectrum>
      spectra;               // [effect][noise][filter over time, the frame alone first], where they are put out
  std::vector<double> bias;  // [effect][stage]: rms distance of the filtered truth from the converged one
  // [noise][stage]: error over that of white noise as the score of the texture promises it, where they are put out.
  std::vector<std::optional<double>> predictions;
  std::vector<PassResult> passes;
  // What is to be known of it, a sentence each: first what is said of how noises are read, then of what was made.
  std::vector<std::string> notes;
  double seconds = 0;  // of the wall
  int threads = 1;

  double square(std::size_t effect, std::size_t noise, int repeat, std::size_t stage, int frame) const;
  // Error over that of the noise called "white"; NaN where there is none, or where that has none.
  double over_white(std::size_t effect, std::size_t noise, std::size_t stage, int frame) const;
  std::optional<double> prediction(std::size_t noise, std::size_t stage) const;
  // Root of the mean over repeats, and its standard error.
  MeanAndError rmse(std::size_t effect, std::size_t noise, std::size_t stage, int frame) const;
  // Of any metric that was measured; of one repeat as it is kept, squared where it is a root.
  double of_repeat(Metric metric, std::size_t effect, std::size_t noise, int repeat, std::size_t stage,
                   int frame) const;
  MeanAndError value(Metric metric, std::size_t effect, std::size_t noise, std::size_t stage, int frame) const;
  // Filters over time, the frame alone among them.
  std::size_t num_times() const;
  const ErrorSpectrum& spectrum(std::size_t effect, std::size_t noise, std::size_t time) const {
    return spectra[(effect * noises.size() + noise) * num_times() + time];
  }

 private:
  std::size_t place(std::size_t effect, std::size_t noise, int repeat, std::size_t stage, int frame) const;
};

// What is done to noises so that the effects can use them, a sentence each: directions that are bent to another
// density.
std::vector<std::string> notes_of_reading(const Scene& scene, const std::vector<Noise>& noises);

// Renders the scene with noises that were opened. Throws UserError where an effect cannot use one of them.
Result render(const Scene& scene, const std::vector<Noise>& noises, ThreadPool& pool);
// The same with another table of passes.
Result render(const Scene& scene, const std::vector<Noise>& noises, ThreadPool& pool, std::span<const Pass> passes);

struct ExpectationResult {
  std::string text;  // "a < b after ema + box5, frame 64"
  Outcome outcome;
  std::string found;  // the numbers
};
std::vector<ExpectationResult> check_expectations(const Scene& scene, const Result& result);

// For people and programs.
std::string plan_text(std::span<const PlannedPass> passes);
std::string plan_json(const Scene& scene, const std::vector<PassResult>& passes, double seconds, int threads);
// What a metric is, in words.
std::string title_of(Metric metric);
std::string results_text(const Result& result);
std::string results_csv(const Result& result);  // last frame
std::string curves_csv(const Result& result);   // every frame
std::string spectra_csv(const Result& result);

}  // namespace noiseloom::render
