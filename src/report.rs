//! What people and scripts read: verdict.json, report.html and plots. Computes nothing.
