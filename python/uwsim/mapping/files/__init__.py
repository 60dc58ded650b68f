"""Files of maps and of point clouds: .bt and .ot; .pcd, .ply, .las and .xyz; depth grids as GeoTIFF."""

from uwsim.mapping.files.cloud_files import CLOUD_FORMATS, read_cloud, write_cloud

__all__ = ["CLOUD_FORMATS", "read_cloud", "write_cloud"]
