#include <cmath>

#include <Eigen/LU>

#include "common/error.h"
#include "common/gaussian.h"
#include "datasets/file_source.h"
#include "datasets/landmark_recording.h"
#include "datasets/number_table.h"
#include "vehicle/arc.h"

namespace hymm::core {
namespace {

constexpr char kFileName[] = "map.circles";

// The file's axes are those of an image that looks down: X to the right, -Y forward, angles
// clockwise. base_link has x forward, y left, angles counter-clockwise. The matrix is its own
// inverse.
const Eigen::Matrix3d& baseFromFile() {
  static const Eigen::Matrix3d matrix =
      (Eigen::Matrix3d() << 0.0, -1.0, 0.0, -1.0, 0.0, 0.0, 0.0, 0.0, -1.0).finished();
  return matrix;
}

Eigen::Matrix3d symmetric(double xx, double xy, double yy, double xz, double yz, double zz) {
  return (Eigen::Matrix3d() << xx, xy, xz, xy, yy, yz, xz, yz, zz).finished();
}

/// The twist that over `duration_s` displaces a vehicle along an arc by exactly `displacement`
/// (x, y, yaw in its first axes) with exactly `covariance`: MotionModel::step inverted.
TwistInput twistOfDisplacement(double time_s, double duration_s,
                               const Eigen::Vector3d& displacement,
                               const Eigen::Matrix3d& covariance) {
  const Arc arc(displacement.z());
  const Eigen::Vector2d chord = arc.V().inverse() * displacement.head<2>();
  const Eigen::Matrix3d J_inverse = arc.velocityJacobian(chord, duration_s).inverse();
  TwistInput twist;
  twist.time_s = time_s;
  twist.forward_mps = chord.x() / duration_s;
  twist.lateral_mps = chord.y() / duration_s;
  twist.yaw_rate_radps = displacement.z() / duration_s;
  const Eigen::Matrix3d density = J_inverse * covariance * J_inverse.transpose() * duration_s;
  twist.density = 0.5 * (density + density.transpose());
  return twist;
}

/// A point with covariance, in Cartesian coordinates of the sensor, as range and bearing.
Observation rangeBearing(const Eigen::Vector2d& point, const Eigen::Matrix2d& covariance) {
  Observation observation;
  observation.range_m = point.norm();
  observation.bearing_rad = std::atan2(point.y(), point.x());
  const Eigen::Vector2d radial = point / observation.range_m;
  Eigen::Matrix2d J;
  J << radial.x(), radial.y(),  //
      -radial.y() / observation.range_m, radial.x() / observation.range_m;
  observation.covariance = J * covariance * J.transpose();
  return observation;
}

class DlrReader {
 public:
  explicit DlrReader(std::string origin) : origin_(std::move(origin)) {}

  LandmarkRecording read(std::string_view text) {
    while (!text.empty()) {
      ++line_;
      const std::size_t length = std::min(text.find('\n'), text.size());
      readLine(text.substr(0, length));
      text.remove_prefix(std::min(length + 1, text.size()));
    }
    if (steps_ == 0) fail("holds no STEP line; give the file map.circles of the DLR set");
    finishStep();
    // The vehicle stands still after its last step, so that the last input does not go on.
    recording_.events.emplace_back(MotionInput(TwistInput{endOfStep(), 0.0, 0.0, 0.0}));
    count("observations without identity", without_identity_);
    count("observations with several identities, taken as not identified", ambiguous_);
    count("observations at the sensor's place or with an unusable covariance, skipped", unusable_);
    recording_.name = "DLR spatial cognition";
    return std::move(recording_);
  }

 private:
  void readLine(std::string_view line) {
    const std::vector<std::string_view> words = splitWords(line);
    if (words.empty() || words.front().front() == '#') return;
    if (words.front() == "STEP") {
      readStep(words);
    } else if (words.front() == "LANDMARK" || words.front() == "LANDMARK_C") {
      readLandmark(words);
    } else {
      fail("begins with '" + std::string(words.front()) +
           "', which is neither STEP nor LANDMARK; correct it or get the file again");
    }
  }

  void readStep(const std::vector<std::string_view>& words) {
    if (words.size() != 11) failLength(words.size(), "11");
    const auto number = [&](std::size_t i) { return numberOf(words[i]); };
    const Eigen::Vector3d displacement(number(2), number(3), number(4));
    const Eigen::Matrix3d covariance =
        symmetric(number(5), number(6), number(7), number(8), number(9), number(10));
    if (!isSemiDefiniteCovariance(covariance)) {
      fail("the covariance of the step is not positive semi-definite; get the file again");
    }
    if (std::abs(displacement.z()) > kPi) fail("the step turns by more than half a turn");

    if (steps_ > 0) finishStep();
    const double start_s = static_cast<double>(steps_) * kDlrStep_s;
    const Eigen::Matrix3d& M = baseFromFile();
    recording_.events.emplace_back(MotionInput(twistOfDisplacement(
        start_s, kDlrStep_s, M * displacement, M * covariance * M.transpose())));
    ++steps_;
  }

  void readLandmark(const std::vector<std::string_view>& words) {
    if (words.size() < 8) failLength(words.size(), "at least 8");
    if (steps_ == 0) fail("a landmark comes before the first step; get the file again");
    const auto number = [&](std::size_t i) { return numberOf(words[i]); };
    const Eigen::Matrix2d M = baseFromFile().topLeftCorner<2, 2>();
    const Eigen::Vector2d point = M * Eigen::Vector2d(number(1), number(2));
    // Read before the matrix is begun: Eigen asserts that one which is begun is also filled.
    const double xx = number(4), xy = number(5), yy = number(6);
    const Eigen::Matrix2d covariance = (Eigen::Matrix2d() << xx, xy, xy, yy).finished();
    const int identity = identityOf(words);
    if (point.norm() == 0.0 || !isCovariance(covariance)) {
      ++unusable_;
      return;
    }
    seen_.observations.push_back(rangeBearing(point, M * covariance * M.transpose()));
    seen_.observations.back().identity = identity;
  }

  int identityOf(const std::vector<std::string_view>& words) {
    for (std::size_t i = 7; i < words.size(); ++i) {
      const double value = numberOf(words[i]);
      if (value != std::floor(value) || value < -1.0 || value > 1e9) {
        fail("'" + std::string(words[i]) + "' is not an identity; get the file again");
      }
    }
    if (words.size() > 8) {
      ++ambiguous_;
      return -1;
    }
    const int identity = static_cast<int>(numberOf(words[7]));
    if (identity < 0) ++without_identity_;
    return identity;
  }

  void finishStep() {
    seen_.time_s = endOfStep();
    recording_.events.emplace_back(std::move(seen_));
    seen_ = ObservationSet{};
  }

  double endOfStep() const { return static_cast<double>(steps_) * kDlrStep_s; }

  double numberOf(std::string_view word) const {
    const std::optional<double> value = tryParseNumber(word);
    if (!value || !std::isfinite(*value)) {
      fail("'" + std::string(word) + "' is not a finite number; correct it or get the file again");
    }
    return *value;
  }

  [[noreturn]] void failLength(std::size_t words, const std::string& expected) const {
    fail("has " + std::to_string(words) + " fields instead of " + expected +
         "; the file is cut off or damaged, get it again");
  }

  [[noreturn]] void fail(const std::string& problem) const {
    throw InputError(origin_ + ", line " + std::to_string(line_) + ": " + problem + ".");
  }

  void count(const std::string& what, std::size_t number) {
    if (number > 0) recording_.counts.push_back({what, number});
  }

  std::string origin_;
  std::size_t line_ = 0;
  std::size_t steps_ = 0;
  std::size_t without_identity_ = 0;
  std::size_t ambiguous_ = 0;
  std::size_t unusable_ = 0;
  ObservationSet seen_;
  LandmarkRecording recording_;
};

}  // namespace

LandmarkRecording readDlr(const std::filesystem::path& path) {
  const bool is_folder = std::filesystem::is_directory(path);
  const std::filesystem::path file = is_folder ? path / kFileName : path;
  return DlrReader(file.string()).read(readFile(file));
}

}  // namespace hymm::core
