// SPDX-License-Identifier: MIT
#include "gyrostat/host/metrics.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <random>
#include <stdexcept>
#include <vector>

namespace gyrostat::host::test_metrics {
namespace {

template <class M>
double of(const Series& s, std::vector<double> numbers = {}) {
  M metric;
  std::size_t next = 0;
  M::describe(metric, [&](double& member, const Field&) {
    if (next < numbers.size()) member = numbers[next++];
  });
  return measured(metric, s);
}

std::vector<double> every_second(std::size_t n) {
  std::vector<double> t(n);
  for (std::size_t k = 0; k < n; ++k) t[k] = static_cast<double>(k);
  return t;
}

TEST(SettlingTime, EndsAtTheFirstSampleAfterTheLastExcursion) {
  const std::vector<double> t = every_second(6), x{5, 0.1, 3, 0.2, 0.1, 0.3};
  EXPECT_EQ(of<SettlingTime>({t, x}, {0.5}), 3.0);
}

TEST(SettlingTime, IsNeverWhenTheLastSampleIsOutside) {
  const std::vector<double> t = every_second(3), x{0, 0, 1};
  EXPECT_TRUE(std::isnan(of<SettlingTime>({t, x}, {0.5})));
}

TEST(SettlingTime, IsCountedFromAGivenInstantAndJudgesEveryColumn) {
  const std::vector<double> t = every_second(4);
  const std::vector<double> x{0, 0, 0, -2, 0, 0, 0.1, -0.1};  // 4 samples of 2
  EXPECT_EQ(of<SettlingTime>({t, x}, {0.5}), 2.0);
  EXPECT_EQ(of<SettlingTime>({t, x}, {0.5, 1.0}), 1.0);
  EXPECT_EQ(of<SettlingTime>({t, x}, {0.5, 3.0}), 0.0);
}

TEST(SettlingTime, IsNeverWithANaN) {
  const std::vector<double> t = every_second(3), x{0, 0, std::nan("")};
  EXPECT_TRUE(std::isnan(of<SettlingTime>({t, x}, {0.5})));
}

TEST(Windows, AreClosedAtBothEnds) {
  const std::vector<double> t = every_second(5), x{9, -2, 1, 3, 9};
  EXPECT_EQ(of<WindowMax>({t, x}, {1, 3}), 3.0);
  EXPECT_EQ(of<WindowLowest>({t, x}, {1, 3}), -2.0);
  EXPECT_EQ(of<WindowHighest>({t, x}, {1, 3}), 3.0);
  EXPECT_DOUBLE_EQ(of<WindowRms>({t, x}, {1, 3}), std::sqrt((4.0 + 1.0 + 9.0) / 3));
  const std::vector<double> spoilt{0, std::nan(""), 0, 0, 0};
  const Series with_nan{t, spoilt};
  for (const double value : {of<WindowMax>(with_nan), of<WindowNorm>(with_nan), of<WindowRms>(with_nan),
                             of<WindowLowest>(with_nan), of<WindowHighest>(with_nan)}) {
    EXPECT_TRUE(std::isnan(value));
  }
  EXPECT_THROW((void)of<WindowMax>({t, x}, {10, 12}), std::invalid_argument);
}

TEST(Windows, NormTakesAllColumns) {
  const std::vector<double> t = every_second(2), x{3, 4, 1, 1};
  EXPECT_DOUBLE_EQ(of<WindowNorm>({t, x}, {0, 1}), 5.0);
  EXPECT_DOUBLE_EQ(of<WindowMax>({t, x}, {0, 1}), 4.0);
}

TEST(Energy, HoldsEachCommandToTheNextSample) {
  const std::vector<double> t{0, 1, 3}, u{2, 3, 100};
  EXPECT_DOUBLE_EQ(of<Energy>({t, u}), 4.0 * 1 + 9.0 * 2);
}

TEST(TotalVariation, IsPerSecondAndSumsColumns) {
  const std::vector<double> t{0, 1, 2}, u{0, 0, 1, -1, 0, 0};
  EXPECT_DOUBLE_EQ(of<TotalVariation>({t, u}, {0, 2}), (2.0 + 2.0) / 2);
}

TEST(Fractions, CountSamplesAtALevel) {
  const std::vector<double> t = every_second(4), u{0.25, -0.25, 0.1, 0.25};
  EXPECT_DOUBLE_EQ(of<FractionAtLeast>({t, u}, {0.25, 0, 3}), 0.75);
  EXPECT_EQ(of<FirstReach>({t, u}, {0.25, 0.5}), 1.0);
  EXPECT_TRUE(std::isnan(of<FirstReach>({t, u}, {0.3})));
}

TEST(Series, RefusesLengthsThatDoNotFit) {
  const std::vector<double> t = every_second(3), x{1, 2, 3, 4};
  EXPECT_THROW((void)of<SettlingTime>({t, x}, {1}), std::invalid_argument);
}

TEST(Recovery, LeavesOutTheSampleOfTheFaultAndWhatComesAfterUntil) {
  const std::vector<double> t = every_second(6), x{0, 9, 1, 0.1, 0.2, 7};
  EXPECT_TRUE(std::isnan(of<Recovery>({t, x}, {0.5, 1.0})));
  EXPECT_EQ(of<Recovery>({t, x}, {0.5, 1.0, 4.0}), 2.0);
  EXPECT_EQ(of<Recovery>({t, x}, {10, 1.0}), 1.0);
}

TEST(Final, IsTheLastSample) {
  const std::vector<double> t = every_second(2), x{5, 5, -2, 1};
  EXPECT_EQ(of<Final>({t, x}), 2.0);
}

// Definitions over the whole series at once, which need all of it in memory.
struct Whole {
  const std::vector<double>&t, &x;
  std::size_t width = x.size() / t.size();

  std::vector<std::size_t> rows(double t0, double t1) const {
    std::vector<std::size_t> out;
    for (std::size_t k = 0; k < t.size(); ++k) {
      if (t[k] >= t0 - 1e-9 && t[k] <= t1 + 1e-9) out.push_back(k);
    }
    return out;
  }
  double size(std::size_t k) const {
    double m = 0;
    for (std::size_t i = 0; i < width; ++i) m = std::max(m, std::abs(x[k * width + i]));
    return m;
  }
  double squares(std::size_t k) const {
    double sum = 0;
    for (std::size_t i = 0; i < width; ++i) sum += x[k * width + i] * x[k * width + i];
    return sum;
  }
  double settling(double band, double after) const {
    std::size_t k = t.size();
    while (k > 0 && t[k - 1] >= after - 1e-9 && size(k - 1) < band) --k;
    return k == t.size() ? std::nan("") : t[k] - after;
  }
  double max(double t0, double t1) const {
    double m = 0;
    for (std::size_t k : rows(t0, t1)) m = std::max(m, size(k));
    return m;
  }
  double rms(double t0, double t1) const {
    double sum = 0;
    for (std::size_t k : rows(t0, t1)) sum += squares(k);
    return std::sqrt(sum / static_cast<double>(rows(t0, t1).size()));
  }
  double energy() const {
    double sum = 0;
    for (std::size_t k = 0; k + 1 < t.size(); ++k) sum += squares(k) * (t[k + 1] - t[k]);
    return sum;
  }
  double variation(double t0, double t1) const {
    double sum = 0;
    const auto in = rows(t0, t1);
    for (std::size_t k = in.front() + 1; k <= in.back(); ++k) {
      for (std::size_t i = 0; i < width; ++i) sum += std::abs(x[k * width + i] - x[(k - 1) * width + i]);
    }
    return sum / (t[in.back()] - t[in.front()]);
  }
  double fraction(double level, double t0, double t1) const {
    double count = 0;
    for (std::size_t k : rows(t0, t1)) count += size(k) >= level * (1 - 1e-9) ? 1 : 0;
    return count / static_cast<double>(rows(t0, t1).size());
  }
};

bool same_bits(double a, double b) { return std::isnan(a) ? std::isnan(b) : std::memcmp(&a, &b, sizeof a) == 0; }

TEST(Metrics, OfOneSampleAfterTheOtherAreThoseOfTheWholeSeries) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> uniform(0, 1);
  for (int trial = 0; trial < 300; ++trial) {
    const std::size_t n = 3 + random() % 40, width = 1 + random() % 5;
    std::vector<double> t(n), x(n * width);
    for (std::size_t k = 0; k < n; ++k) t[k] = (k == 0 ? 0 : t[k - 1]) + 0.01 + uniform(random);
    for (double& v : x) v = (uniform(random) - 0.5) * 3;
    const Series s{t, x};
    const Whole whole{t, x};
    const double t0 = t[random() % (n - 1)], t1 = t[n - 1] - (random() % 2 == 0 ? 0.0 : 1e-10),
                 band = 2 * uniform(random);
    EXPECT_PRED2(same_bits, of<SettlingTime>(s, {band, t0}), whole.settling(band, t0));
    EXPECT_PRED2(same_bits, of<WindowMax>(s, {t0, t1}), whole.max(t0, t1));
    EXPECT_PRED2(same_bits, of<WindowRms>(s, {t0, t1}), whole.rms(t0, t1));
    EXPECT_PRED2(same_bits, of<Energy>(s), whole.energy());
    EXPECT_PRED2(same_bits, of<TotalVariation>(s, {t0, t1}), whole.variation(t0, t1));
    EXPECT_PRED2(same_bits, of<FractionAtLeast>(s, {band, t0, t1}), whole.fraction(band, t0, t1));
    EXPECT_PRED2(same_bits, of<Final>(s), whole.size(n - 1));
  }
}

/// A metric that somebody else wrote: this struct is all; in Metric it would have a name for claims and experiments too.
struct Mean {
  static constexpr const char* name = "mean";
  static constexpr const char* meaning = "mean of the first column";
  double sum = 0, count = 0;
  static constexpr void describe(auto&, auto&&) {}
  void add(double, std::span<const double> x) noexcept {
    sum += x[0];
    count += 1;
  }
  double value() const noexcept { return count > 0 ? sum / count : measure::never; }
};

TEST(Metrics, ThatAreNotInTheListMeasureASeries) {
  static_assert(Accumulator<Mean>);
  const std::vector<double> t = every_second(3), x{1, 9, 2, 9, 6, 9};
  EXPECT_DOUBLE_EQ(measured(Mean{}, {t, x}), 3.0);
}

template <class... M>
void each_metric(std::type_identity<std::variant<M...>>, auto&& look) {
  (look.template operator()<M>(), ...);
}

TEST(Metrics, OfNothingAreNeverAndSizesAreChecked) {
  each_metric(std::type_identity<Metric>(), []<class M>() {
    static_assert(Accumulator<M>);
    EXPECT_TRUE(std::isnan(M{}.value())) << M::name;
    const std::vector<double> t = every_second(3), x{1, 2, 3, 4};
    EXPECT_THROW((void)measured(M{}, {t, x}), std::invalid_argument) << M::name;
    EXPECT_THROW((void)measured(M{}, {{}, {}}), std::invalid_argument) << M::name;
  });
}

}  // namespace
}  // namespace gyrostat::host::test_metrics
