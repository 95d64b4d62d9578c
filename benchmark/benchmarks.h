#pragma once

#include <string>

#include "benchmark/plain_names.h"

namespace hymm::benchmarks {

struct ScanOptions {
  int scans = 700;           ///< over 20 area switches at 5 m/s
  double live_speed = 2.0;   ///< pace of the scans, as a multiple of the live one; 0: at once
  bool stays_awake = false;  ///< between scans: asks for the time, instead of sleeping
  std::string perf_control;  ///< FIFO that tells perf when the drive begins and ends
};

/// BM_ScanCompressedEkf, BM_ScanFullEkf.
void registerScanBenchmarks(Registration& registration, const ScanOptions& options);

/// BM_GlobalUpdate, BM_Dsyrk.
void registerGlobalUpdateBenchmarks(Registration& registration);

/// BM_ParticleUpdate, BM_ParticleUpdateKnownIdentities, BM_ParticleUpdateNearest.
void registerParticleBenchmarks(Registration& registration);

/// BM_Association, BM_AssociationByDensity.
void registerAssociationBenchmarks(Registration& registration);

/// BM_LevelSetIncremental, BM_LevelSetFull, BM_LevelSetScratch.
void registerLevelSetBenchmarks(Registration& registration);

/// BM_DoorPlannerQuery, BM_DoorPlannerChange, BM_GridAStarQuery.
void registerDoorPlannerBenchmarks(Registration& registration);

/// BM_MapCorrection, BM_Rerasterise.
void registerMapCorrectionBenchmarks(Registration& registration);

/// BM_RayInsertionLtr, BM_RayInsertionOctoMap, BM_RayInsertionFlatGrid.
void registerRayInsertionBenchmarks(Registration& registration);

}  // namespace hymm::benchmarks
