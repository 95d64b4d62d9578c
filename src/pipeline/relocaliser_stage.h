#pragma once

#include "pipeline/suite_stage.h"
#include "relocaliser/relocalisation.h"

namespace hymm::core {

/// The engine of the node `relocaliser` in an offline run.
class RelocaliserStage : public SuiteStage {
 public:
  static constexpr const char* kName = "relocaliser";

  RelocaliserStage(const RelocaliserConfig& config, const VehicleConfig& vehicle);

  void takeEvent(const SensorEvent& event) override;
  void takeScan(const ScanStep& step, CekfSlam& filter) override;
  void reset(double time_s) override;
  void addTo(RunTotals& totals) const override;
  std::map<std::string, std::size_t> incidents() const override;
  void write(const std::filesystem::path&) override {}

  /// Of the scan that was taken last.
  const SearchReport& report() const { return relocalisation_.report(); }
  /// What the supervisor decided, after the same scan.
  void begin(const SearchOrder& order, CekfSlam& filter);
  void end() { relocalisation_.end(); }

 private:
  /// Asks the engine itself.
  class EngineLink : public FilterLink {
   public:
    std::vector<LandmarkEstimate> landmarks() override;
    std::string suspend(double time_T0_s) override;
    std::optional<FilterKnowledge> ask(const std::vector<int>& ids, std::string& problem) override;
    ResumeAnswer resume(double time_T0_s, const std::vector<PlaceAtScan>& path,
                        bool elsewhere) override;

    CekfSlam* filter = nullptr;  ///< of the call that is on
  };

  void workOff();

  EngineLink link_;
  Relocalisation relocalisation_;
  double cpu_s_ = 0.0;
};

}  // namespace hymm::core
