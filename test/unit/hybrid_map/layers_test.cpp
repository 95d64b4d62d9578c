#include <array>
#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/random.h"
#include "hybrid_map/layer_set.h"

namespace hymm::core {
namespace {

LayerSample valueOf(double value, double variance) {
  LayerSample sample;
  sample.value = value;
  sample.variance = variance;
  return sample;
}

TEST(GaussianModel, AveragesByCertainty) {
  const auto model = makeGaussianModel();
  std::array<float, 4> cell{};
  EXPECT_FALSE(model->read(cell.data()));
  model->add(valueOf(10.0, 4.0), 1.0, cell.data());
  model->add(valueOf(13.0, 2.0), 1.0, cell.data());
  const auto value = model->read(cell.data());
  ASSERT_TRUE(value);
  EXPECT_NEAR(value->value, 12.0, 1e-5);
  // 4/3 were the measurements as good as they claim; their scatter, (9 / 6) / (2 - 1), says 1.5.
  EXPECT_NEAR(value->variance, 1.5 * 4.0 / 3.0, 1e-5);
}

TEST(GaussianModel, KeepsPrecisionFarFromZero) {
  const auto model = makeGaussianModel();
  RandomGenerator generator(1);
  std::array<float, 4> cell{};
  for (int i = 0; i < 1000; ++i) {
    model->add(valueOf(300.0 + sampleNormal(generator, 0.1), 0.01), 1.0, cell.data());
  }
  const auto value = model->read(cell.data());
  EXPECT_NEAR(value->value, 300.0, 4 * 0.1 / std::sqrt(1000.0));
  EXPECT_NEAR(value->variance, 0.01 / 1000.0, 0.2 * 0.01 / 1000.0);
}

TEST(GaussianModel, RefusesMeasurementsWithoutVariance) {
  const auto model = makeGaussianModel();
  EXPECT_TRUE(model->problemWith(valueOf(1.0, 0.0)));
  EXPECT_TRUE(model->problemWith(valueOf(NAN, 1.0)));
  EXPECT_TRUE(model->problemWith(valueOf(1.0, NAN)));
  EXPECT_FALSE(model->problemWith(valueOf(1.0, 1.0)));
}

TEST(GaussianModel, RefusesWhatACellCannotHoldAndSaysWhy) {
  const auto model = makeGaussianModel();
  EXPECT_THAT(*model->problemWith(valueOf(1e39, 1.0)), testing::HasSubstr("beyond 1e15"));
  EXPECT_THAT(*model->problemWith(valueOf(-3e38, 1.0)), testing::HasSubstr("beyond 1e15"));
  EXPECT_THAT(*model->problemWith(valueOf(1.0, 1e-40)), testing::HasSubstr("within 1e-30"));
  EXPECT_THAT(*model->problemWith(valueOf(1.0, 1e50)), testing::HasSubstr("within 1e-30"));
}

TEST(GaussianModel, StaysFiniteWhateverUsableSamplesCome) {
  const auto model = makeGaussianModel();
  std::array<float, 4> cell{}, moved{};
  for (const double value : {1e15, -1e15, 0.0, 1.0, -1e-15}) {
    for (const double variance : {1e-30, 1.0, 1e30}) {
      for (const double share : {1.0, 0.04}) {
        const LayerSample sample = valueOf(value, variance);
        ASSERT_FALSE(model->problemWith(sample));
        model->add(sample, share, cell.data());
        model->merge(cell.data(), 1.0F / 9.0F, moved.data());
        for (const auto& known : {model->read(cell.data()), model->read(moved.data())}) {
          ASSERT_TRUE(known);
          ASSERT_TRUE(std::isfinite(known->value)) << value << " " << variance;
          ASSERT_TRUE(std::isfinite(known->variance)) << value << " " << variance;
        }
      }
    }
  }
}

TEST(GaussianModel, TakesAValueForNoMoreCertainThanItsFloat) {
  const auto model = makeGaussianModel();
  std::array<float, 4> cell{};
  model->add(valueOf(1e6, 1e-20), 1.0, cell.data());
  // Floats about 1e6 lie 2^-4 apart.
  EXPECT_GT(std::sqrt(model->read(cell.data())->variance), 1.0 / 32.0);
  EXPECT_LT(std::sqrt(model->read(cell.data())->variance), 1.0 / 8.0);
}

TEST(CategoryModel, RefusesWeightsThatACellCannotHold) {
  const auto model = makeCategoryModel({"grass", "asphalt"});
  for (const double weight : {1e39, 1e-46, 1e16}) {
    LayerSample sample = valueOf(weight, 0.0);
    sample.label = "grass";
    const auto problem = model->problemWith(sample);
    ASSERT_TRUE(problem) << weight;
    EXPECT_THAT(*problem, testing::HasSubstr("within 1e-15 and 1e15"));
  }
}

TEST(RateModel, RefusesWhatACellCannotHoldAndTimesWithoutATimeOfDay) {
  const auto model = makeRateModel(4, {});
  const auto problem = [&](double time_s, double events, double exposure_s) {
    LayerSample sample = valueOf(events, 0.0);
    sample.time_s = time_s;
    sample.exposure_s = exposure_s;
    return model->problemWith(sample).value_or("");
  };
  EXPECT_EQ(problem(1e9, 0.0, 1800.0), "");
  EXPECT_THAT(problem(1e9, 1e39, 1800.0), testing::HasSubstr("number of events is not within"));
  EXPECT_THAT(problem(1e9, 1e-46, 1800.0), testing::HasSubstr("number of events is not within"));
  EXPECT_THAT(problem(1e9, 1.0, 1e-46), testing::HasSubstr("was watched is not within"));
  EXPECT_THAT(problem(1e9, 1.0, 1e43), testing::HasSubstr("was watched is not within"));
  EXPECT_THAT(problem(1e300, 1.0, 1800.0), testing::HasSubstr("no time of day"));
}

TEST(CategoryModel, CountsWhatWasSeen) {
  const auto model = makeCategoryModel({"grass", "asphalt", "sand"});
  std::array<float, 3> cell{};
  LayerSample sample = valueOf(1.0, 0.0);
  for (const char* label : {"asphalt", "sand", "asphalt", "asphalt"}) {
    sample.label = label;
    EXPECT_FALSE(model->problemWith(sample));
    model->add(sample, 1.0, cell.data());
  }
  const auto value = model->read(cell.data());
  EXPECT_EQ(value->value, 1.0);
  EXPECT_EQ(value->parts, (std::vector<double>{0.0, 0.75, 0.25}));
  sample.label = "snow";
  EXPECT_THAT(*model->problemWith(sample), testing::HasSubstr("'snow'"));
}

TEST(RateModel, TellsClassesOfTimeApart) {
  const auto model = makeRateModel(4, {"dry", "wet"});
  std::vector<float> cell(std::size_t(model->channels()), 0.0F);
  const double kMonday_s = 4 * 86400.0, kSaturday_s = 2 * 86400.0;
  const auto watch = [&](double time_s, double events, const char* weather) {
    LayerSample sample;
    sample.time_s = time_s;
    sample.value = events;
    sample.exposure_s = 1800.0;
    sample.label = weather;
    EXPECT_FALSE(model->problemWith(sample));
    model->add(sample, 1.0, cell.data());
  };
  watch(kMonday_s + 3600.0 * 8, 20, "dry");    // part 1, working day
  watch(kMonday_s + 3600.0 * 9, 30, "dry");    // the same class
  watch(kSaturday_s + 3600.0 * 23, 2, "wet");  // part 3, weekend
  const auto value = model->read(cell.data());
  ASSERT_EQ(value->parts.size(), 16U);
  EXPECT_DOUBLE_EQ(value->parts[1], 50.0);
  EXPECT_DOUBLE_EQ(value->parts[(1 * 2 + 1) * 4 + 3], 4.0);
  EXPECT_TRUE(std::isnan(value->parts[0]));
  EXPECT_NEAR(value->value, 52.0 / 1.5, 1e-5);
}

class AnyModel : public testing::TestWithParam<int> {
 public:
  std::unique_ptr<CellModel> model() const {
    if (GetParam() == 0) return makeOccupancyModel();
    if (GetParam() == 1) return makeGaussianModel();
    if (GetParam() == 2) return makeCategoryModel({"a", "b"});
    return makeRateModel(2, {});
  }
  /// A cell that has learned something.
  std::vector<float> learned(double value) const {
    std::vector<float> cell(std::size_t(model()->channels()), 0.0F);
    if (GetParam() == 0) {
      cell[0] = static_cast<float>(value);
    } else {
      LayerSample sample = valueOf(value, 0.5);
      sample.label = "b";
      sample.exposure_s = 7200.0;
      model()->add(sample, 1.0, cell.data());
    }
    return cell;
  }
};

TEST_P(AnyModel, DividesAndJoinsEvidenceWithoutLoss) {
  std::vector<float> source = learned(2.0), target = learned(3.0);
  const double before = model()->evidence(source.data()) + model()->evidence(target.data());
  model()->merge(source.data(), 0.25F, target.data());
  model()->keep(0.75F, source.data());
  const double after = model()->evidence(source.data()) + model()->evidence(target.data());
  EXPECT_NEAR(after, before, 1e-6 * before);
}

TEST_P(AnyModel, AllOfACellMovedIntoAnEmptyOneReadsTheSame) {
  const std::vector<float> source = learned(2.0);
  std::vector<float> target(source.size(), 0.0F);
  for (int i = 0; i < 4; ++i) model()->merge(source.data(), 0.25F, target.data());
  const auto before = model()->read(source.data()), after = model()->read(target.data());
  EXPECT_NEAR(after->value, before->value, 1e-6);
  EXPECT_EQ(std::isnan(after->variance), std::isnan(before->variance));
  EXPECT_FALSE(std::abs(after->variance - before->variance) > 1e-6);  // nor if not a number
  std::vector<float> left = source;
  model()->keep(0.0F, left.data());
  EXPECT_FALSE(model()->read(left.data()));
}

INSTANTIATE_TEST_SUITE_P(Models, AnyModel, testing::Range(0, 4));

TEST(LayerSet, ReadsItsDescription) {
  std::vector<std::string> problems;
  const LayerSet layers("height gaussian;terrain category grass asphalt ; traffic rate dry wet;", 6,
                        problems);
  EXPECT_TRUE(problems.empty());
  EXPECT_EQ(layers.names(),
            (std::vector<std::string>{"occupancy", "height", "terrain", "traffic"}));
  EXPECT_EQ(layers.find("terrain"), 2);
  EXPECT_EQ(layers.find("nothing"), -1);
  EXPECT_EQ(layers.channelsTogether(), 1 + 4 + 2 + 2 * 24);
}

TEST(LayerSet, TellsEveryEntryThatIsWrong) {
  std::vector<std::string> problems;
  const LayerSet layers("a; b gausian; c category only; occupancy gaussian; d gaussian x", 4,
                        problems);
  EXPECT_EQ(layers.count(), 1);
  ASSERT_EQ(problems.size(), 5U);
  EXPECT_THAT(problems[1], testing::HasSubstr("no cell model 'gausian'"));
  EXPECT_THAT(problems[3], testing::HasSubstr("'occupancy'"));
}

}  // namespace
}  // namespace hymm::core
