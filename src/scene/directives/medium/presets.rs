//! The media that pbrt knows by name. All of them scatter.

use crate::scene::model::Rgb;

/// Names, and absorption coefficients in 1/mm. The first twelve are from Jensen and others, "A Practical Model
/// for Subsurface Light Transport", 2001, figure 5; the others from Narasimhan and others, "Acquiring
/// Scattering Properties of Participating Media by Dilution", 2006, table 1.
const PRESETS: &[(&str, [f64; 3])] = &[
    ("Apple", [0.0030, 0.0034, 0.046]),
    ("Chicken1", [0.015, 0.077, 0.19]),
    ("Chicken2", [0.018, 0.088, 0.20]),
    ("Cream", [0.0002, 0.0028, 0.0163]),
    ("Ketchup", [0.061, 0.97, 1.45]),
    ("Marble", [0.0021, 0.0041, 0.0071]),
    ("Potato", [0.0024, 0.0090, 0.12]),
    ("Skimmilk", [0.0014, 0.0025, 0.0142]),
    ("Skin1", [0.032, 0.17, 0.48]),
    ("Skin2", [0.013, 0.070, 0.145]),
    ("Spectralon", [0.0, 0.0, 0.0]),
    ("Wholemilk", [0.0011, 0.0024, 0.014]),
    ("Lowfat Milk", [0.002875, 0.00575, 0.0115]),
    ("Reduced Milk", [0.0025556, 0.0051111, 0.012778]),
    ("Regular Milk", [0.0015333, 0.0046, 0.019933]),
    ("Espresso", [4.7984, 6.5751, 8.8493]),
    ("Mint Mocha Coffee", [3.772, 5.8228, 7.82]),
    ("Lowfat Soy Milk", [0.0014375, 0.0071875, 0.035937]),
    ("Regular Soy Milk", [0.0019167, 0.0095833, 0.065167]),
    ("Lowfat Chocolate Milk", [0.0115, 0.0368, 0.1564]),
    ("Regular Chocolate Milk", [0.010063, 0.043125, 0.14375]),
    ("Coke", [0.10014, 0.16503, 0.2468]),
    ("Pepsi", [0.091641, 0.14158, 0.20729]),
    ("Sprite", [0.001886, 0.0018308, 0.0020025]),
    ("Gatorade", [0.024794, 0.019289, 0.008878]),
    ("Chardonnay", [0.010782, 0.011855, 0.023997]),
    ("White Zinfandel", [0.012072, 0.016184, 0.019843]),
    ("Merlot", [0.11632, 0.25191, 0.29434]),
    ("Budweiser Beer", [0.011492, 0.024911, 0.057786]),
    ("Coors Light Beer", [0.006164, 0.013984, 0.034983]),
    ("Clorox", [0.0033542, 0.014892, 0.026297]),
    ("Apple Juice", [0.012957, 0.023741, 0.052184]),
    ("Cranberry Juice", [0.039437, 0.094223, 0.12426]),
    ("Grape Juice", [0.10404, 0.23958, 0.29325]),
    ("Ruby Grapefruit Juice", [0.085867, 0.18314, 0.25262]),
    ("White Grapefruit Juice", [0.0138, 0.018831, 0.056781]),
    ("Shampoo", [0.014107, 0.045693, 0.061717]),
    ("Strawberry Shampoo", [0.01449, 0.05796, 0.075823]),
    ("Head & Shoulders Shampoo", [0.084621, 0.15688, 0.20365]),
    ("Lemon Tea Powder", [2.4288, 4.5757, 7.2127]),
    ("Orange Powder", [0.001449, 0.003441, 0.007863]),
    ("Pink Lemonade Powder", [0.001165, 0.002366, 0.003195]),
    ("Cappuccino Powder", [35.844, 49.547, 61.084]),
    ("Salt Powder", [0.28415, 0.3257, 0.34148]),
    ("Sugar Powder", [0.012638, 0.031051, 0.050124]),
    ("Suisse Mocha Powder", [17.502, 27.004, 35.433]),
    ("Pacific Ocean Surface Water", [0.031845, 0.031324, 0.030147]),
];

/// Returns the absorption coefficient of a preset in 1/mm, or `None` if there is no preset of that name.
pub(super) fn preset_absorption(name: &str) -> Option<Rgb> {
    PRESETS.iter().find(|(known, _)| *known == name).map(|(_, absorption)| Rgb::from(*absorption))
}
