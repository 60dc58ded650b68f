"""Files of maps (.bt, .ot), point clouds (.pcd, .ply, .las, .laz, .xyz) and depth grids (GeoTIFF)."""

from uwsim.mapping.files.cloud_files import read_cloud, write_cloud
from uwsim.mapping.files.formats import CLOUD_FORMATS

__all__ = ["CLOUD_FORMATS", "read_cloud", "write_cloud"]
