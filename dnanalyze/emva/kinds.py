"""The quantities by name: EMVA 1288 Release 4.0 symbols where the standard has them."""

from __future__ import annotations

from dnanalyze.emva.quantity import Kind

MEAN = Kind("mean_dark_signal_dn", "μ_y.dark", "mean dark signal", "DN")
NOISE = Kind("temporal_dark_noise_dn", "σ_y.dark", "temporal dark noise", "DN")
NOISE_E = Kind("temporal_dark_noise_e", "σ_d", "temporal dark noise", "e-")
DSNU = Kind("dsnu_dn", "s_y.dark", "DSNU", "DN")
ROW = Kind("dsnu_row_dn", "s_y.dark.row", "DSNU, rows", "DN")
COLUMN = Kind("dsnu_col_dn", "s_y.dark.col", "DSNU, columns", "DN")
PIXEL = Kind("dsnu_pixel_dn", "s_y.dark.pixel", "DSNU, pixels", "DN")
PARTS = {"dsnu_1288": DSNU, "dsnu_1288_row": ROW, "dsnu_1288_col": COLUMN, "dsnu_1288_pix": PIXEL}
IN_ELECTRONS = {
    DSNU: Kind("dsnu_e", "DSNU1288", "DSNU", "e-"),
    ROW: Kind("dsnu_row_e", "DSNU1288.row", "DSNU, rows", "e-"),
    COLUMN: Kind("dsnu_col_e", "DSNU1288.col", "DSNU, columns", "e-"),
    PIXEL: Kind("dsnu_pixel_e", "DSNU1288.pixel", "DSNU, pixels", "e-"),
}
SKEWNESS = Kind("skewness", "", "skewness, mean dark image", "1")
HOT_5 = Kind("hot_5_sigma_percent", "", "hot pixels > 5 σ", "%")
HOT_CURRENT = Kind("hot_10_times_percent", "", "hot pixels > 10 × median μ_c", "%")
SLOPES = {
    "spatial": Kind("slope_spatial", "", "1/f slope, spatial", "1"),
    "spatial_rows": Kind("slope_spatial_rows", "", "1/f slope, spatial, rows", "1"),
    "spatial_columns": Kind("slope_spatial_columns", "", "1/f slope, spatial, columns", "1"),
    "temporal": Kind("slope_temporal", "", "1/f slope, temporal", "1"),
    "temporal_rows": Kind("slope_temporal_rows", "", "1/f slope, temporal, rows", "1"),
    "temporal_columns": Kind("slope_temporal_columns", "", "1/f slope, temporal, columns", "1"),
}

GAIN = Kind("system_gain_dn_e", "K", "overall system gain", "DN/e-")
TRANSFER = Kind("photon_transfer_gain_dn_e", "K", "system gain, photon transfer", "DN/e-")
CURRENT = Kind("dark_current_mean_dn_s", "μ_c.mean", "dark current", "DN/s")
CURRENT_E = Kind("dark_current_mean_e_s", "μ_c.mean", "dark current", "e-/s")
CURRENT_VARIANCE = Kind("dark_current_var_e_s", "μ_c.var", "dark current, variance", "e-/s")
OFFSET = Kind("mean_dark_signal_0_dn", "μ_y.dark.0", "mean dark signal at exposure 0", "DN")
DOUBLING = Kind("doubling_temperature_c", "T_d", "doubling temperature", "C")
ENERGY = Kind("activation_energy_ev", "E_a", "activation energy", "eV")
