// Relocalisations in the world `loop`: one line of CSV for each scan of each seed from FIRST to
// LAST; with a third argument, the particles of the first seed into that file.
// scripts/experiments/loop_closing makes figures of it.

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <memory>

#include "support/relocalisation_run.h"

namespace hymm {
namespace {

constexpr std::size_t kScans = 52;
constexpr std::size_t kHelicalSamples = 20000;

/// Writes "what,scan,x,y,yaw": the helical regions, particles, landmarks and the truth, map frame.
class Snapshots {
 public:
  Snapshots(const char* path, const core::RelocaliserConfig& config)
      : file_(path), config_(config) {
    file_ << "what,scan,x,y,yaw\n";
  }

  void take(const core::Relocaliser& relocaliser, const core::ObservationSet& set,
            const core::Pose2& truth, std::size_t scan) {
    const core::Pose2& T_map_local = relocaliser.map().T_map_local;
    if (scan == 0) {
      for (const auto& landmark : relocaliser.map().landmarks) {
        const Eigen::Vector2d p = T_map_local * landmark.position;
        write("landmark", scan, {p.x(), p.y(), 0.0});
      }
      writeAll("helix", scan, T_map_local, helicalSamples(relocaliser, set));
    }
    if (scan != 0 && scan != 2 && scan != 5 && scan != 51) return;
    write("truth", scan, truth);
    writeAll("particle", scan, T_map_local, relocaliser.particles());
  }

 private:
  core::ParticleSet helicalSamples(const core::Relocaliser& relocaliser,
                                   const core::ObservationSet& set) const {
    const auto points = core::observedPoints(set, config_.density.min_deviation_m);
    const core::DensityMap density(relocaliser.map().landmarks, points, 1000.0, config_.density);
    const core::PosePrior prior = relocaliser.prior().value();
    const core::HelicalRegions regions{
        relocaliser.map().landmarks,
        points,
        {prior.mean.yaw_rad, 3.0 * std::sqrt(prior.covariance(2, 2))},
        prior,
        3.0};
    core::RandomGenerator generator(1);
    return core::sampleHelicalRegions(regions, density, kHelicalSamples, generator);
  }

  void writeAll(const char* what, std::size_t scan, const core::Pose2& T_map_local,
                const core::ParticleSet& particles) {
    for (std::size_t i = 0; i < particles.size(); ++i) {
      write(what, scan, T_map_local * particles.pose(i));
    }
  }
  void write(const char* what, std::size_t scan, const core::Pose2& pose) {
    file_ << what << ',' << scan << ',' << pose.x_m << ',' << pose.y_m << ',' << pose.yaw_rad
          << '\n';
  }

  std::ofstream file_;
  core::RelocaliserConfig config_;
};

void print(std::uint64_t seed, const test::RelocalisationRun& run) {
  for (std::size_t i = 0; i < run.scans.size(); ++i) {
    const test::RelocalisationScan& scan = run.scans[i];
    const core::RelocaliserOutcome& outcome = scan.outcome;
    std::printf("%llu,%zu,%g,%g,%zu,%g,%g,%g,%g,%g,%zu,%zu,%d,%d,%g,%g,%d,%g,%g,%g,%g,%g\n",
                static_cast<unsigned long long>(seed), i, run.prior_error_m, run.prior_deviation_m,
                run.map_landmarks, scan.error_m, scan.heading_error_rad, scan.cekf_error_m,
                std::sqrt(outcome.covariance(0, 0)), std::sqrt(outcome.covariance(1, 1)),
                outcome.particles, outcome.modes.size(), outcome.converged ? 1 : 0,
                scan.resumed ? 1 : 0, scan.resumed_error_m, scan.resumed_nees,
                run.resumption.closing_pairs, run.resumption.inflation, run.map_error_before_m,
                run.map_error_after_m, run.map_error_alone_m, scan.nees);
  }
  if (!run.problem.empty())
    std::fprintf(stderr, "seed %llu: %s\n", static_cast<unsigned long long>(seed),
                 run.problem.c_str());
  if (run.accepted)
    std::fprintf(stderr, "seed %llu: %s\n", static_cast<unsigned long long>(seed),
                 run.resumption.reason.c_str());
}

}  // namespace
}  // namespace hymm

int main(int argc, char** argv) {
  using namespace hymm;
  if (argc < 3) {
    std::fprintf(stderr, "Usage: relocalisation FIRST_SEED LAST_SEED [PARTICLE_FILE]\n");
    return 2;
  }
  const std::uint64_t first = std::strtoull(argv[1], nullptr, 10);
  const std::uint64_t last = std::strtoull(argv[2], nullptr, 10);
  std::puts(
      "seed,scan,prior_error_m,prior_deviation_m,map_landmarks,error_m,heading_error_rad,"
      "cekf_error_m,deviation_x_m,deviation_y_m,particles,modes,converged,resumed,resumed_error_m,"
      "resumed_nees,closing_pairs,inflation,map_before_m,map_after_m,map_alone_m,nees");
  for (std::uint64_t seed = first; seed <= last; ++seed) {
    test::LoopRelocalisation loop(seed);
    test::LoopRelocalisation::Watch watch;
    std::unique_ptr<Snapshots> snapshots;
    if (argc > 3 && seed == first) {
      snapshots = std::make_unique<Snapshots>(argv[3], loop.relocaliser());
      watch = [&](const auto&... all) { snapshots->take(all...); };
    }
    print(seed, loop.run(loop.relocaliser(), kScans, watch));
    std::fflush(stdout);
  }
  return 0;
}
