#include "sink/csv_tables.h"

#include <string>
#include <variant>

#include "core/quantity.h"

namespace vildar {
namespace {

constexpr std::string_view kSpeedsHeader =
    "track_id,direction,lane,status,t_first_s,t_last_s,t_ref_s,speed_mps,speed_std_mps,speed_lo95_"
    "mps,"
    "speed_hi95_mps,speed_kmh,range_ref_m,lateral_m,acceleration_mps2,sensors,method,n_frames,"
    "n_pd_samples,closing_speed_mps\n";
constexpr std::string_view kMethodsHeader =
    "track_id,method,status,t_ref_s,speed_mps,speed_std_mps,speed_lo95_mps,speed_hi95_mps,n_"
    "samples,"
    "k_source\n";
constexpr std::string_view kTracksHeader =
    "frame,t_s,track_id,u_left_px,v_left_px,u_right_px,v_right_px,intensity,intensity_std,"
    "saturated,"
    "azimuth_rad,elevation_rad,range_m,range_std_m,speed_mps,speed_std_mps,intensity_left,"
    "intensity_right,azimuth_left_rad,elevation_left_rad,azimuth_right_rad,elevation_right_rad,"
    "u_left_std_px,v_left_std_px,u_right_std_px,v_right_std_px\n";
constexpr std::string_view kBlobsHeader =
    "frame,t_s,blob_id,u_px,v_px,u_std_px,v_std_px,flux,flux_std,area_px,saturated_px,kind\n";

// Digits well below what any sensor resolves, so that a table loses nothing a reader could use.
constexpr int kTimeDigits = 6;
constexpr int kSpeedDigits = 6;
constexpr int kMetreDigits = 4;
constexpr int kPixelDigits = 4;
constexpr int kAngleDigits = 8;
constexpr int kLightDigits = 7;  // significant ones: light spans decades

std::string withheld_status(Miss miss) { return "withheld:" + std::string(name_of(miss)); }

std::string_view sensors_of(const VehicleResult& vehicle) {
  if (vehicle.used_camera && vehicle.used_photodiode) return "camera+photodiode";
  if (vehicle.used_camera) return "camera";
  return vehicle.used_photodiode ? "photodiode" : "";
}

void append_estimate(CsvRow& row, const SpeedEstimate& speed) {
  row.fixed(speed.time_s, kTimeDigits)
      .fixed(speed.speed_mps, kSpeedDigits)
      .fixed(speed.std_mps, kSpeedDigits)
      .fixed(speed.lo95_mps, kSpeedDigits)
      .fixed(speed.hi95_mps, kSpeedDigits);
}

void append_lamp_place(CsvRow& row, const std::optional<LampSighting>& lamp) {
  if (!lamp) {
    row.empty(2);
    return;
  }
  row.fixed(lamp->centre_px.x(), kPixelDigits).fixed(lamp->centre_px.y(), kPixelDigits);
}

// A lamp cut by the edge of the image is not where its light's centre seems to be.
void append_lamp_sigma(CsvRow& row, const std::optional<LampSighting>& lamp) {
  if (!lamp || has(lamp->defects, Defect::cut_by_edge)) {
    row.empty(2);
    return;
  }
  row.fixed(lamp->centre_sigma_px.x(), kPixelDigits).fixed(lamp->centre_sigma_px.y(), kPixelDigits);
}

void append_lamp_light(CsvRow& row, const std::optional<LampSighting>& lamp) {
  row.significant(lamp ? std::optional(light_of(*lamp).flux) : std::nullopt, kLightDigits);
}

void append_bearing(CsvRow& row, const std::optional<Eigen::Vector2d>& bearing_rad) {
  if (!bearing_rad) {
    row.empty(2);
    return;
  }
  row.fixed(bearing_rad->x(), kAngleDigits).fixed(bearing_rad->y(), kAngleDigits);
}

int saturated_px(const VehicleSighting& sighting) {
  return (sighting.left ? sighting.left->saturated_px : 0) +
         (sighting.right ? sighting.right->saturated_px : 0);
}

}  // namespace

AtomicFile write_speeds(const std::filesystem::path& path,
                        std::span<const VehicleResult> vehicles) {
  AtomicFile file(path);
  file.write(kSpeedsHeader);
  CsvRow row;
  for (const VehicleResult& vehicle : vehicles) {
    const bool measured = !vehicle.withheld.has_value();
    row.integer(vehicle.track_id)
        .text(name_of(vehicle.direction))
        .text(vehicle.lane)
        .text(measured ? "measured" : withheld_status(*vehicle.withheld))
        .fixed(vehicle.t_first_s, kTimeDigits)
        .fixed(vehicle.t_last_s, kTimeDigits);
    if (measured) {
      append_estimate(row, vehicle.speed);
      row.fixed(kmh_from_mps(vehicle.speed.speed_mps), kSpeedDigits)
          .fixed(vehicle.range_ref_m, kMetreDigits);
    } else {
      row.empty(7);
    }
    row.fixed(vehicle.lateral_m, kMetreDigits)
        .fixed(measured ? vehicle.acceleration_mps2 : std::nullopt, kSpeedDigits)
        .text(sensors_of(vehicle))
        .text(measured ? name_of(vehicle.method) : "")
        .integer(vehicle.n_frames)
        .integer(vehicle.n_pd_samples)
        .fixed(measured ? vehicle.closing_speed_mps : std::nullopt, kSpeedDigits);
    file.write(row.line());
  }
  file.finish();
  return file;
}

AtomicFile write_methods(const std::filesystem::path& path,
                         std::span<const VehicleResult> vehicles) {
  AtomicFile file(path);
  file.write(kMethodsHeader);
  CsvRow row;
  for (const VehicleResult& vehicle : vehicles) {
    for (const MethodResult& result : vehicle.methods) {
      row.integer(vehicle.track_id).text(name_of(result.method));
      if (const auto* speed = std::get_if<SpeedEstimate>(&result.speed)) {
        row.text("measured");
        append_estimate(row, *speed);
      } else {
        row.text(withheld_status(std::get<Miss>(result.speed))).empty(5);
      }
      row.integer(result.samples).text(result.k_source);
      file.write(row.line());
    }
  }
  file.finish();
  return file;
}

TracksWriter::TracksWriter(const std::filesystem::path& path) : file_(path) {
  file_.write(kTracksHeader);
}

void TracksWriter::add(std::span<const TrackRow> rows) {
  for (const TrackRow& track : rows) {
    const VehicleSighting& sighting = track.sighting;
    row_.integer(sighting.frame).fixed(track.time_s, kTimeDigits).integer(track.track_id);
    append_lamp_place(row_, sighting.left);
    append_lamp_place(row_, sighting.right);
    row_.significant(track.intensity, kLightDigits)
        .significant(track.intensity_std, kLightDigits)
        .integer(saturated_px(sighting));
    append_bearing(row_, track.bearing_rad);
    row_.fixed(track.range_m, kMetreDigits)
        .fixed(track.range_std_m, kMetreDigits)
        .fixed(track.speed_mps, kSpeedDigits)
        .fixed(track.speed_std_mps, kSpeedDigits);
    append_lamp_light(row_, sighting.left);
    append_lamp_light(row_, sighting.right);
    append_bearing(row_, track.bearing_left_rad);
    append_bearing(row_, track.bearing_right_rad);
    append_lamp_sigma(row_, sighting.left);
    append_lamp_sigma(row_, sighting.right);
    file_.write(row_.line());
  }
}

AtomicFile TracksWriter::finish() && {
  file_.finish();
  return std::move(file_);
}

BlobsWriter::BlobsWriter(const std::filesystem::path& path) : file_(path) {
  file_.write(kBlobsHeader);
}

void BlobsWriter::add(const BlobFrame& frame) {
  for (const Blob& blob : frame.blobs) {
    row_.integer(frame.frame)
        .fixed(seconds_of(frame.time), kTimeDigits)
        .integer(blob.id)
        .fixed(blob.centre_px.x(), kPixelDigits)
        .fixed(blob.centre_px.y(), kPixelDigits)
        .fixed(blob.centre_sigma_px.x(), kPixelDigits)
        .fixed(blob.centre_sigma_px.y(), kPixelDigits)
        .significant(light_of(blob).flux, kLightDigits)
        .significant(light_of(blob).flux_sigma, kLightDigits)
        .integer(blob.area_px)
        .integer(blob.saturated_px)
        .text(name_of(blob.kind));
    file_.write(row_.line());
  }
}

AtomicFile BlobsWriter::finish() && {
  file_.finish();
  return std::move(file_);
}

}  // namespace vildar
