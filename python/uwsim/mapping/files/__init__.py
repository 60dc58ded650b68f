"""File formats for maps (.bt, .ot), point clouds (.pcd, .ply, .las, .xyz) and depth grids (GeoTIFF)."""

from uwsim.mapping.files.cloud_files import CLOUD_FORMATS, read_cloud, write_cloud

__all__ = ["CLOUD_FORMATS", "read_cloud", "write_cloud"]
