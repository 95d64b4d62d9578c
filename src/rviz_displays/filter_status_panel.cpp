#include "rviz_displays/filter_status_panel.h"

#include <QHBoxLayout>
#include <QScrollArea>
#include <QVBoxLayout>
#include <cmath>

#include <hymm/Pause.h>
#include <hymm/SaveMap.h>
#include <pluginlib/class_list_macros.hpp>
#include <std_srvs/Empty.h>

namespace hymm {
namespace {

constexpr int kRefreshEvery_ms = 200;
constexpr double kHealthOld_s = 3.0;
constexpr int kLeastTableHeight_px = 230;

QString colourOf(const QString& mode) {
  if (mode == QString::fromStdString(FilterStatus::CEKF)) return "#2e8b57";
  if (mode == QString::fromStdString(FilterStatus::RELOCALISING)) return "#d98e04";
  if (mode == QString::fromStdString(FilterStatus::LOST)) return "#c0392b";
  return "#5d6d7e";
}

QLabel* wrappingLabel() {
  auto* label = new QLabel;
  label->setWordWrap(true);
  label->setTextFormat(Qt::PlainText);
  label->setTextInteractionFlags(Qt::TextSelectableByMouse);
  return label;
}

QString number(double value) { return std::isfinite(value) ? QString::number(value, 'g', 3) : "?"; }

QString row(const QString& name, const QString& value) {
  return "<tr><td>" + name.toHtmlEscaped() + "&nbsp;&nbsp;</td><td><b>" + value.toHtmlEscaped() +
         "</b></td></tr>";
}

/// However low the panel is, nothing is squeezed.
QScrollArea* scrolling(std::initializer_list<QWidget*> widgets) {
  auto* column = new QVBoxLayout;
  column->setContentsMargins(0, 0, 0, 0);
  for (QWidget* widget : widgets) column->addWidget(widget);
  column->addStretch();
  auto* content = new QWidget;
  content->setLayout(column);
  auto* area = new QScrollArea;
  area->setFrameShape(QFrame::NoFrame);
  area->setWidgetResizable(true);
  area->setHorizontalScrollBarPolicy(Qt::ScrollBarAlwaysOff);
  area->setMinimumHeight(kLeastTableHeight_px);
  area->setWidget(content);
  return area;
}

QString percent(double share) { return number(100.0 * share) + " %"; }

}  // namespace

FilterStatusPanel::FilterStatusPanel(QWidget* parent)
    : rviz::Panel(parent),
      mode_(new QLabel),
      reason_(wrappingLabel()),
      evidence_(new QLabel),
      health_(new QLabel),
      answer_(wrappingLabel()),
      path_(new QLineEdit),
      relocalise_(new QPushButton("Relocalise")),
      pause_(new QPushButton("Pause")),
      save_(new QPushButton("Save")) {
  mode_->setAlignment(Qt::AlignCenter);
  relocalise_->setToolTip("Look for the vehicle's place in the map (global_localization)");
  pause_->setToolTip("Stop or go on taking in sensor data (pause)");
  save_->setToolTip("Save the whole map in the folder below (save_map)");
  path_->setPlaceholderText("folder to save in, an absolute path");
  auto* buttons = new QHBoxLayout;
  for (QPushButton* button : {relocalise_, pause_, save_}) buttons->addWidget(button);
  auto* column = new QVBoxLayout;
  column->addWidget(mode_);
  column->addWidget(reason_);
  column->addWidget(scrolling({evidence_, health_}), 1);
  column->addLayout(buttons);
  column->addWidget(path_);
  column->addWidget(answer_);
  setLayout(column);
  evidence_->setVisible(false);
  showMode("NO STATUS", "No filter_status has come. Is the supervisor running?");
  connect(relocalise_, SIGNAL(clicked()), this, SLOT(relocalise()));
  connect(pause_, SIGNAL(clicked()), this, SLOT(pause()));
  connect(save_, SIGNAL(clicked()), this, SLOT(saveMap()));
  connect(path_, SIGNAL(editingFinished()), this, SIGNAL(configChanged()));
  connect(&timer_, SIGNAL(timeout()), this, SLOT(refresh()));
}

void FilterStatusPanel::onInitialize() {
  // RViz spins the global queue in the thread of its window.
  status_subscriber_ = handle_.subscribe("filter_status", 10, &FilterStatusPanel::takeStatus, this);
  health_subscriber_ = handle_.subscribe("cekf/health", 10, &FilterStatusPanel::takeHealth, this);
  timer_.start(kRefreshEvery_ms);
}

void FilterStatusPanel::load(const rviz::Config& config) {
  rviz::Panel::load(config);
  QString path;
  if (config.mapGetString("Folder", &path)) path_->setText(path);
}

void FilterStatusPanel::save(rviz::Config config) const {
  rviz::Panel::save(config);
  config.mapSetValue("Folder", path_->text());
}

void FilterStatusPanel::showMode(const QString& mode, const QString& reason) {
  mode_->setText(mode);
  mode_->setStyleSheet("QLabel { background-color: " + colourOf(mode) +
                       "; color: white; font-weight: bold; font-size: 16pt; padding: 6px; }");
  reason_->setText(reason);
}

void FilterStatusPanel::takeStatus(const FilterStatus& message) {
  showMode(QString::fromStdString(message.mode), QString::fromStdString(message.reason));
  QString rows;
  for (const Evidence& evidence : message.evidence) {
    const QString limit =
        std::isfinite(evidence.limit) ? " (limit " + number(evidence.limit) + ")" : "";
    rows += row(QString::fromStdString(evidence.name), number(evidence.value) + limit);
  }
  evidence_->setText("<table>" + rows + "</table>");
  evidence_->setVisible(!rows.isEmpty());
}

void FilterStatusPanel::takeHealth(const FilterHealth& message) {
  health_at_ = ros::WallTime::now();
  const QString nis =
      message.dof > 0 ? number(message.nis / static_cast<double>(message.dof)) : "no pairing";
  QString rows = row("NIS per degree of freedom", nis);
  rows += row("ambiguous observations", percent(message.ambiguity));
  rows += row("unexplained observations", percent(message.unexplained));
  rows += row("missed landmarks", percent(message.missed));
  rows += row("position, 1 sigma", number(message.position_deviation) + " m");
  rows += row("heading, 1 sigma", number(message.heading_deviation) + " rad");
  rows += row("a scan took", number(message.latency_ms) + " ms");
  rows += row("scans, dropped",
              QString::number(message.scans) + ", " + QString::number(message.dropped_scans));
  rows += row("landmarks", QString::number(message.landmarks));
  health_->setText("<table>" + rows + "</table>");
  health_->setEnabled(true);
}

void FilterStatusPanel::refresh() {
  calls_.poll();
  const bool old = (ros::WallTime::now() - health_at_).toSec() > kHealthOld_s;
  // Grey: what it says was some time ago.
  if (!health_at_.isZero()) health_->setEnabled(!old);
}

void FilterStatusPanel::answer(const QString& sentence) { answer_->setText(sentence); }

void FilterStatusPanel::relocalise() {
  answer("Asked to relocalise.");
  calls_.call<std_srvs::Empty>(
      handle_.resolveName("global_localization"), {},
      [this](bool reached, const std_srvs::Empty::Response&) {
        answer(reached ? "Relocalising was asked for; the mode above tells what comes of it."
                       : "Nobody answers global_localization. Is the supervisor running?");
      });
}

void FilterStatusPanel::pause() {
  Pause::Request request;
  request.pause = !paused_;
  calls_.call<Pause>(handle_.resolveName("pause"), request,
                     [this, wanted = !paused_](bool reached, const Pause::Response& response) {
                       if (reached && response.success) paused_ = wanted;
                       pause_->setText(paused_ ? "Go on" : "Pause");
                       answer(reached ? QString::fromStdString(response.message)
                                      : "Nobody answers pause. Is cekf_slam running?");
                     });
}

void FilterStatusPanel::saveMap() {
  SaveMap::Request request;
  request.path = path_->text().trimmed().toStdString();
  if (request.path.empty() || request.path.front() != '/') {
    answer("Name a folder to save in, as an absolute path.");
    return;
  }
  save_->setEnabled(false);
  answer("Saving.");
  calls_.call<SaveMap>(handle_.resolveName("save_map"), request,
                       [this](bool reached, const SaveMap::Response& response) {
                         save_->setEnabled(true);
                         answer(reached ? QString::fromStdString(response.message)
                                        : "Nobody answers save_map. Is the supervisor running?");
                       });
}

}  // namespace hymm

PLUGINLIB_EXPORT_CLASS(hymm::FilterStatusPanel, rviz::Panel)
