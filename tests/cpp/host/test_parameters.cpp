// SPDX-License-Identifier: MIT
#include "gyrostat/host/parameters.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

namespace gyrostat::host::test_parameters {
namespace {

struct Params {
  enum class Method : std::uint8_t { implicit_root, explicit_euler };
  double bandwidth = 2;
  int substeps = 1;
  bool adapt = true;
  Method method = Method::implicit_root;
  Vec3<double> gain = Vec3<double>::Constant(1);
  Mat3<double> weight = Mat3<double>::Identity();
  VecN<double> limit;
  Quat<double> q = Quat<double>::Identity();
  truth::Waveform remaining = 1.0;
  double angle = 0;

  static constexpr void describe(auto& p, auto&& field) {
    field(p.bandwidth, Field{"bandwidth", "rad/s", 1e-2, 1e2, "both poles sit at -bandwidth"});
    field(p.substeps, Field{"substeps", "", 1, 100, "of the explicit method"});
    field(p.adapt, Switch{"adapt", "whether gains grow"});
    field(p.method, Choice{"method", "implicit|explicit_euler", "discrete form"});
    field(p.gain, Field{"gain", "1/s", 0, unbounded, "per axis"});
    field(p.weight, Field{"weight", "", -10, 10, "a matrix"});
    field(p.limit, Field{"limit", "N m", 0, std::numeric_limits<double>::infinity(), "one an actuator"});
    field(p.q, Field{"q", "", -1.1, 1.1, "an attitude"});
    field(p.remaining, Field{"remaining", "", 0, 1, "a waveform"});
    field(p.angle, Field{"angle", "rad", -full_turn, full_turn, "an angle", "degrees"});
  }
};

const Place place{"observer 'mine'", 4};

Params read_from(const Table& table) { return read_params(Params{}, table, place); }

std::string message_of(const Table& table) {
  try {
    (void)read_from(table);
  } catch (const std::invalid_argument& e) {
    return e.what();
  }
  return "accepted";
}

TEST(Parameters, UnwrittenOnesKeepTheirDefaults) {
  const Params p = read_from({{"type", "mine"}, {"substeps", 3}});
  EXPECT_EQ(p.bandwidth, 2.0);
  EXPECT_EQ(p.substeps, 3);
  EXPECT_TRUE(p.adapt);
}

TEST(Parameters, OneNumberFillsAVectorAndADiagonal) {
  const Params p = read_from({{"gain", 3}, {"weight", List{1, 2, 3}}, {"limit", 0.5}});
  EXPECT_EQ(p.gain, Vec3<double>(3, 3, 3));
  EXPECT_EQ(p.weight, Mat3<double>(Vec3<double>(1, 2, 3).asDiagonal()));
  EXPECT_EQ(p.limit.size(), 4);
}

TEST(Parameters, WaveformsMayBeNumbersOrTables) {
  EXPECT_EQ(read_from({{"remaining", 0.25}}).remaining(7.0), 0.25);
  const Params p =
      read_from({{"remaining", Table{{"type", "sine"}, {"offset", 0.5}, {"amplitude", 0.1}, {"omega", 2.0}}}});
  EXPECT_DOUBLE_EQ(p.remaining(0.3), 0.5 + 0.1 * std::sin(0.6));
}

TEST(Parameters, EveryKindOfWaveformIsHeldToTheRange) {
  const auto wave = [](const char* type, Table more) {
    more.set("type", type);
    return more;
  };
  const Table sine = wave("sine", {{"offset", 0.5}, {"amplitude", -0.4}});
  const List times{0.0, 1.0};
  const auto inside = [&](const Table& table) { return message_of({{"remaining", table}}) == "accepted"; };
  EXPECT_TRUE(inside(sine));
  EXPECT_TRUE(inside(wave("sum", {{"terms", List{sine, 0.1}}})));
  EXPECT_FALSE(inside(wave("constant", {{"value", 1.5}})));
  EXPECT_FALSE(inside(wave("sine", {{"offset", 0.5}, {"amplitude", -0.6}})));
  EXPECT_FALSE(inside(wave("square", {{"low", -0.1}, {"high", 1}})));
  EXPECT_FALSE(inside(wave("square", {{"low", 1.1}, {"high", 0}})));
  EXPECT_FALSE(inside(wave("steps", {{"times", times}, {"values", List{0.5, 1.5}}})));
  EXPECT_FALSE(inside(wave("table", {{"times", times}, {"values", List{-0.5, 0.5}}})));
  EXPECT_FALSE(inside(wave("sum", {{"terms", List{sine, 0.2}}})));
}

struct Bad {
  const char* why;
  Table table;
  const char* message;
};

class BadParameters : public testing::TestWithParam<Bad> {};
INSTANTIATE_TEST_SUITE_P(
    All, BadParameters,
    testing::Values(
        Bad{"range", {{"bandwidth", -1}}, "observer 'mine': bandwidth = -1 is outside [0.01, 100]"},
        Bad{"nan", {{"bandwidth", std::nan("")}}, "observer 'mine': bandwidth = nan is not a number"},
        Bad{"infinite", {{"gain", INFINITY}}, "observer 'mine': gain = inf must be finite"},
        Bad{"unknown", {{"bandwith", 1}}, "observer 'mine': no parameter 'bandwith', did you mean 'bandwidth'?"},
        Bad{"text", {{"bandwidth", "fast"}}, "observer 'mine': bandwidth = 'fast' is a text; a number belongs here"},
        Bad{"fraction", {{"substeps", 1.5}}, "observer 'mine': substeps = 1.5 must be a whole number"},
        Bad{"number_for_bool", {{"adapt", 1}}, "observer 'mine': adapt = 1 is an integer; true or false belongs here"},
        Bad{"option", {{"method", "rk4"}}, "observer 'mine': method = 'rk4' is not one of: implicit, explicit_euler"},
        Bad{"short_vector",
            {{"gain", List{1, 2}}},
            "observer 'mine': gain = [1, 2] must be a number or a list of 3 numbers, not 2 entries"},
        Bad{"wrong_count",
            {{"limit", List{1, 2, 3}}},
            "observer 'mine': limit = [1, 2, 3] must be a number or a list of 4 numbers, one an actuator, not 3 "
            "entries"},
        Bad{"zero_quaternion",
            {{"q", List{0, 0, 0, 0}}},
            "observer 'mine': q = [0, 0, 0, 0] is zero and names no attitude"},
        Bad{"long_quaternion",
            {{"q", List{1, 1, 0, 0}}},
            "observer 'mine': q = [1, 1, 0, 0] has norm 1.41421; a unit quaternion belongs here (within 1e-3)"},
        Bad{"waveform_type",
            {{"remaining", Table{{"type", "cosine"}}}},
            "observer 'mine': remaining: no waveform 'cosine', did you mean 'sine'?"},
        Bad{"waveform_key",
            {{"remaining", Table{{"type", "sine"}, {"freq", 1}}}},
            "observer 'mine': remaining: no parameter 'freq'; there are: offset, amplitude, omega, phase"},
        Bad{"degrees",
            {{"angle", 90}},
            "observer 'mine': angle = 90 is outside [-6.28319, 6.28319]; looks like degrees"},
        Bad{"long_text",
            {{"bandwidth", std::string(100, 'x')}},
            "observer 'mine': bandwidth = "
            "'xxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxx...' "
            "is a text; a number belongs here"}),
    [](const auto& bad) { return bad.param.why; });

TEST_P(BadParameters, GiveOneLineThatSaysWhatWhereAndWhatIsAllowed) {
  EXPECT_EQ(message_of(GetParam().table), GetParam().message);
}

TEST(Description, CarriesDefaultUnitRangeAndMeaning) {
  const std::vector<ParamInfo> params = describe_params(Params{});
  ASSERT_EQ(params.size(), 10u);
  EXPECT_EQ(params[0].kind, "number");
  EXPECT_EQ(params[0].unit, "rad/s");
  EXPECT_EQ(*params[0].default_value.as<double>(), 2.0);
  EXPECT_EQ(params[3].options, (std::vector<std::string>{"implicit", "explicit_euler"}));
  EXPECT_EQ(*params[3].default_value.as<std::string>(), "implicit");
}

TEST(Nearest, FindsATypoAndNothingFarAway) {
  EXPECT_EQ(nearest("bandwith", {"bandwidth", "gain"}), "bandwidth");
  EXPECT_EQ(nearest("zzz", {"bandwidth", "gain"}), "");
}

}  // namespace
}  // namespace gyrostat::host::test_parameters
