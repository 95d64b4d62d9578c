#pragma once

#include <string>

#include "common/config.h"

namespace hymm::core {

/// When the CEKF's associations are no longer believed. Shares are of one scan.
struct SuspicionConfig {
  double ambiguity = 0.5;            ///< share of observations with several candidates
  double nis_probability = 0.9999;   ///< quantile of chi-square that the scan's NIS exceeds
  double disagreement = 0.5;         ///< of the scan and the stored grid, see GridAgreement
  double unexplained = 0.8;          ///< share of observations that no landmark explains
  double unseen = 0.9;               ///< share of old landmarks that have not been seen lately
  int old_landmarks = 3;             ///< that should be in view for any share to count
  double armed_deviation_m = 1.0;    ///< of the position: arms, and never switches by itself
  double armed_deviation_rad = 0.1;  ///< of the heading, likewise

  void describe(ConfigSchema& schema);
};

/// What one scan says about the CEKF.
struct ScanEvidence {
  double nis = 0.0;
  int dof = 0;
  double ambiguity = 0.0;
  double unexplained = 0.0;
  double missed = 0.0;         ///< told only; what it says is in the next two
  int confirmed_expected = 0;  ///< confirmed landmarks in clear view; 0 where that is not known
  int confirmed_missed = 0;    ///< of these, not seen
  double disagreement = 0.0;   ///< 0 where there is no grid yet
  double unseen = 0.0;         ///< share of the old landmarks expected
  int old_landmarks_expected = 0;
  double position_deviation_m = 0.0;
  double heading_deviation_rad = 0.0;
};

/// Whether the vehicle is so uncertain that association may fail. Exploring makes it so, too: this
/// alone is no reason to doubt.
bool isArmed(const ScanEvidence& scan, const SuspicionConfig& config);

/// What is wrong with the scan, as a clause ("observations are ambiguous"); empty if nothing is.
std::string findSuspicion(const ScanEvidence& scan, const SuspicionConfig& config);

/// Greatest NIS per degree of freedom that is not suspicious.
double nisLimit(int dof, const SuspicionConfig& config);

}  // namespace hymm::core
