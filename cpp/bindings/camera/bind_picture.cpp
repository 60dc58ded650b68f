#include <utility>

#include "bindings/camera/binders.h"
#include "bindings/camera/picture_arrays.h"

namespace uwsim::bindings {
namespace {

/// Moves an image's values into a NumPy array of the given shape without copying them.
template <typename T>
py::array_t<T> move_image_out(ImageBuffer<T>&& values, std::vector<py::ssize_t> shape) {
  auto* owner = new ImageBuffer<T>(std::move(values));
  const py::capsule free(owner, [](void* p) { delete static_cast<ImageBuffer<T>*>(p); });
  return py::array_t<T>(std::move(shape), owner->data(), free);
}

}  // namespace

PictureArrays::PictureArrays(Picture&& picture, const RayRecord& record) : gain(picture.gain) {
  const py::ssize_t height = picture.height, width = picture.width;
  const py::ssize_t rgb_height = picture.rgb.empty() ? 0 : height;
  const py::ssize_t pieces_height = picture.pieces.empty() ? 0 : height;
  const py::ssize_t radiance_height = picture.radiance.empty() ? 0 : height;
  rgb = read_only(move_image_out(std::move(picture.rgb), {rgb_height, width, 3}));
  radiance = read_only(move_out(std::move(picture.radiance), {radiance_height, width, 3}));
  depth_m = read_only(move_image_out(std::move(picture.depth_m), {height, width}));
  normals_world = read_only(move_image_out(std::move(picture.normals_world), {height, width, 3}));
  labels = read_only(move_image_out(std::move(picture.labels), {height, width}));
  classes = read_only(move_image_out(std::move(picture.classes), {height, width}));
  pieces = read_only(move_image_out(std::move(picture.pieces), {pieces_height, width}));
  static_assert(sizeof(RayRecord::Packet) == 580);
  packets = py::bytes(reinterpret_cast<const char*>(record.packets.data()),
                      record.packets.size() * sizeof(RayRecord::Packet));
}

void bind_picture(py::module_& m) {
  py::class_<PictureArrays>(m, "Picture",
                            "A rendered picture as read-only arrays from one pass, rows from the top; see picture.h.")
      .def_readonly("rgb", &PictureArrays::rgb, "(H, W, 3) uint8, sRGB; (0, W, 3) if only geometry was requested")
      .def_readonly("radiance", &PictureArrays::radiance, "(H, W, 3) float32 before exposure, if requested")
      .def_readonly("depth_m", &PictureArrays::depth_m, "(H, W) float32 along the optical axis, inf if nothing is hit")
      .def_readonly("normals_world", &PictureArrays::normals_world, "(H, W, 3) float32, 0 if nothing is hit")
      .def_readonly("labels", &PictureArrays::labels, "(H, W) uint16, see CameraScene.label_names")
      .def_readonly("classes", &PictureArrays::classes, "(H, W) uint8, see CameraScene.class_names")
      .def_readonly("pieces", &PictureArrays::pieces,
                    "(H, W) uint32, the number of the piece of cover, else 0; (0, W) in a world without cover")
      .def_readonly("gain", &PictureArrays::gain, "factor from radiance to exposed signal")
      .def_readonly("packets", &PictureArrays::packets,
                    "The ray packets cast, in the format of tools/bench/native/embree_bare_rays, if recorded");
}

}  // namespace uwsim::bindings
