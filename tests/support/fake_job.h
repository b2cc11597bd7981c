// A job that counts its steps, and a world whose clock and signals a test sets.
#pragma once

#include <fmt/format.h>

#include <functional>
#include <string>
#include <vector>

#include "noiseloom/run/loop.h"

namespace noiseloom {

class FakeJob final : public Job {
 public:
  explicit FakeJob(int num_steps) : num_steps_(num_steps) {}

  void prepare(const Communicator&, ThreadPool&) override {}
  void start(double) override {}
  void restore(const RunFileReader*) override {}
  void step(double) override {
    ++steps_;
    if (after_step) after_step(steps_);
  }
  bool finished() const override { return steps_ >= num_steps_; }
  std::string save(const SaveTarget&) override { return ""; }
  void refresh() override {
    if (on_refresh) on_refresh();
  }
  bool refreshes_quickly() const override { return quick_refresh; }
  std::vector<SliceDataset> datasets() const override { return {}; }
  std::string title() const override { return "fake"; }
  std::string start_words() const override { return ""; }
  bool is_coupled() const override { return false; }
  std::string position() const override { return fmt::format("step {}", steps_); }
  std::size_t num_rows() const override { return static_cast<std::size_t>(steps_); }
  ProgressFigures figures(double, double) override {
    return {0.5, "bar", position(), {{"steps", std::int64_t{1}}}, -1};
  }
  std::vector<std::pair<std::string, std::string>> summary(double) override { return {}; }

  int steps() const { return steps_; }
  std::function<void(int)> after_step;
  std::function<void()> on_refresh;
  bool quick_refresh = true;

 private:
  int num_steps_;
  int steps_ = 0;
};

// Every look at the clock is what the test sets it to; waiting moves it on.
struct FakeWorld {
  double now_s = 0;
  int signal = 0;
  std::vector<double> waits_s;

  Surroundings surroundings() {
    return {[this] { return now_s; }, [this] { return signal; },
            [this](double seconds) {
              waits_s.push_back(seconds);
              now_s += seconds;
            }};
  }
};

}  // namespace noiseloom
